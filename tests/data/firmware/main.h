/* A stand-in for the main.h that STM32CubeMX writes: what the callback of docs/howto/rules-on-a-microcontroller.md uses. */
typedef struct {
    int counter;
} TIM_TypeDef;
typedef struct {
    TIM_TypeDef *Instance;
} TIM_HandleTypeDef;
extern TIM_TypeDef timer_6;
#define TIM6 (&timer_6)

void HAL_TIM_PeriodElapsedCallback(TIM_HandleTypeDef *timer);
float reference(void);
float measured(void);
void drive(float force);
