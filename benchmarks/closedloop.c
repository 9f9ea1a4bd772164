/* The closed loop of benchmarks/closedloop.py as one plain program: robots with encoders, wheel loops, motors and
 * friction, a noisy pose sensor, late commands and the Lyapunov tracking law; every run and robot one after the other.
 * One file, C99, strict IEEE arithmetic, one thread a call. The equations are those of robotics/world/vehicle/plant.py and
 * robotics/laws/tracking/lyapunov.py, and their numbers come from Python. */
#include <math.h>
#include <stddef.h>

enum { STEPS = 5, SUBSTEPS = 4, MOST_LATE = 64, SAMPLES = 14 };

static const double STEP = 0.01; /* s */
static const double PI = 3.14159265358979323846;

typedef struct { /* in the order of the rows of plant.py's parameters */
    double mass, inertia, coupling, radius, half_axle, supply, kt, ke, torque_limit, friction, friction_speed;
    double counts_per_radian, kp, ki, kd, b0, b1, b2, a1, a2, v_max, w_max, wheel_max;
    double odometry_right, odometry_left, odometry_half_axle, v_rate, w_rate, loop_radius;
    double dead_band, v_resolution, w_resolution, longitudinal_slip, lateral_slip, castor_drag, castor_offset, imperfect; /* all 0 */
} Parameters;

typedef struct { double per_mass, per_inertia, per_radius, per_loop_radius, radian, slow, back; } Derived; /* divided once a run */

typedef struct { double x, y, heading; } Pose;

typedef struct {
    double angle, integral, speed, speed_before, raw1, raw2, torque, count; /* of a wheel */
} Wheel;

typedef struct {
    Pose pose, odometry;
    double cos_heading, sin_heading, odometry_cos, odometry_sin;
    double v, w, held_v, held_w, work, loss, effort, variation;
    Wheel right, left;
} Robot;

typedef struct { double kx, ky, kpsi, catch_up; } Gains;

typedef struct { double x, y, heading, v, w; } Reference;

typedef struct { double v, w; } Command;

/* One instruction each, which fmin and fmax with their care for NaN are not. */
static inline double least(double a, double b) { return a < b ? a : b; }
static inline double greatest(double a, double b) { return a > b ? a : b; }
static inline double clamp(double x, double most) { return least(greatest(x, -most), most); }

static double wheel_torque(const Parameters *p, double voltage, double speed) {
    double back = p->ke * speed;
    double torque = p->kt * least(greatest(voltage - back, -p->supply - back), p->supply - back);
    return clamp(torque, p->torque_limit);
}

typedef struct { double v, w, power, loss; } Rates;

static Rates accelerations(const Parameters *p, const Derived *d, double v, double w, double volts_right,
                           double volts_left) {
    double right = (v + p->half_axle * w) * d->per_radius, left = (v - p->half_axle * w) * d->per_radius;
    double motor_right = wheel_torque(p, volts_right, right), motor_left = wheel_torque(p, volts_left, left);
    double drag_right = p->friction * right / sqrt(right * right + d->slow);
    double drag_left = p->friction * left / sqrt(left * left + d->slow);
    double tr = motor_right - drag_right, tl = motor_left - drag_left;
    return (Rates){
        ((tr + tl) * d->per_radius + p->coupling * w * w) * d->per_mass,
        (p->half_axle * (tr - tl) * d->per_radius - p->coupling * v * w) * d->per_inertia,
        motor_right * right + motor_left * left,
        drag_right * right + drag_left * left,
    };
}

/* Move a pose along the arc of a constant twist; the sine and cosine of its heading move along. */
static void arc(Pose *pose, double *cos_heading, double *sin_heading, double forward, double sideways, double turn) {
    double q = turn * turn;
    double s = 1 - q * (1. / 6 - q * (1. / 120 - q * (1. / 5040 - q * (1. / 362880))));
    double c = turn * (1. / 2 - q * (1. / 24 - q * (1. / 720 - q * (1. / 40320 - q * (1. / 3628800)))));
    double cos_turn = 1 - turn * c, sin_turn = turn * s;
    double along = forward * s - sideways * c, across = forward * c + sideways * s;
    double ch = *cos_heading, sh = *sin_heading;
    pose->x += along * ch - across * sh;
    pose->y += along * sh + across * ch;
    pose->heading += turn;
    *cos_heading = ch * cos_turn - sh * sin_turn;
    *sin_heading = sh * cos_turn + ch * sin_turn;
}

/* A PI loop with the rate as its D part, and back-calculation against windup. */
static double wheel_loop(const Parameters *p, const Derived *d, Wheel *wheel, double wanted) {
    double wish = p->kp * (wanted - wheel->speed) + wheel->integral - p->kd * (wheel->speed - wheel->speed_before) * (1 / STEP);
    double voltage = clamp(wish, p->supply);
    wheel->integral += STEP * (p->ki * (wanted - wheel->speed) + d->back * (voltage - wish));
    return voltage;
}

static void runge_kutta(const Parameters *p, const Derived *d, Robot *robot, double volts_right, double volts_left, double h) {
    double v1 = robot->v, w1 = robot->w;
    Rates k1 = accelerations(p, d, v1, w1, volts_right, volts_left);
    double v2 = v1 + 0.5 * h * k1.v, w2 = w1 + 0.5 * h * k1.w;
    Rates k2 = accelerations(p, d, v2, w2, volts_right, volts_left);
    double v3 = v1 + 0.5 * h * k2.v, w3 = w1 + 0.5 * h * k2.w;
    Rates k3 = accelerations(p, d, v3, w3, volts_right, volts_left);
    double v4 = v1 + h * k3.v, w4 = w1 + h * k3.w;
    Rates k4 = accelerations(p, d, v4, w4, volts_right, volts_left);
    double v5 = v1 + h / 6 * (k1.v + 2 * k2.v + 2 * k3.v + k4.v);
    double w5 = w1 + h / 6 * (k1.w + 2 * k2.w + 2 * k3.w + k4.w);
    double forward = h / 6 * (v1 + 2 * v2 + 2 * v3 + v4), turn = h / 6 * (w1 + 2 * w2 + 2 * w3 + w4);
    double sideways = h * h / 12 * (v5 * w1 - v1 * w5);
    robot->work += h / 6 * (k1.power + 2 * k2.power + 2 * k3.power + k4.power);
    robot->loss += h / 6 * (k1.loss + 2 * k2.loss + 2 * k3.loss + k4.loss);
    robot->right.angle += (forward + p->half_axle * turn) * d->per_radius;
    robot->left.angle += (forward - p->half_axle * turn) * d->per_radius;
    robot->v = v5;
    robot->w = w5;
    arc(&robot->pose, &robot->cos_heading, &robot->sin_heading, forward, sideways, turn);
}

/* Read an encoder: how far the wheel has turned, as the loop sees it, and its speed after the filter. */
static double encoder(const Parameters *p, const Derived *d, Wheel *wheel) {
    double count = floor(wheel->angle * p->counts_per_radian);
    double turned = (count - wheel->count) * d->radian, raw = turned * (1 / STEP);
    double speed = p->b0 * raw + p->b1 * wheel->raw1 + p->b2 * wheel->raw2 - p->a1 * wheel->speed
        - p->a2 * wheel->speed_before;
    wheel->count = count;
    wheel->raw2 = wheel->raw1;
    wheel->raw1 = raw;
    wheel->speed_before = wheel->speed;
    wheel->speed = speed;
    return turned;
}

static void step(const Parameters *p, const Derived *d, Robot *robot, Command command) {
    double v = clamp(command.v, p->v_max), w = clamp(command.w, p->w_max);
    double most_v = p->v_rate * STEP, most_w = p->w_rate * STEP;
    v = least(greatest(v, robot->held_v - most_v), robot->held_v + most_v);
    w = least(greatest(w, robot->held_w - most_w), robot->held_w + most_w);
    double right = (v + p->half_axle * w) * d->per_loop_radius, left = (v - p->half_axle * w) * d->per_loop_radius;
    double scale = least(1.0, p->wheel_max / greatest(greatest(fabs(right), fabs(left)), 1e-12));
    robot->held_v = v * scale;
    robot->held_w = w * scale;
    double volts_right = wheel_loop(p, d, &robot->right, right * scale);
    double volts_left = wheel_loop(p, d, &robot->left, left * scale);

    double torque_right = wheel_torque(p, volts_right, (robot->v + p->half_axle * robot->w) * d->per_radius);
    double torque_left = wheel_torque(p, volts_left, (robot->v - p->half_axle * robot->w) * d->per_radius);
    robot->variation += fabs(torque_right - robot->right.torque) + fabs(torque_left - robot->left.torque);
    robot->effort += STEP * (torque_right * torque_right + torque_left * torque_left);
    robot->right.torque = torque_right;
    robot->left.torque = torque_left;

    for (int k = 0; k < SUBSTEPS; k++) runge_kutta(p, d, robot, volts_right, volts_left, STEP / SUBSTEPS);

    double turned_right = encoder(p, d, &robot->right), turned_left = encoder(p, d, &robot->left);
    double way_right = p->odometry_right * turned_right, way_left = p->odometry_left * turned_left;
    arc(&robot->odometry, &robot->odometry_cos, &robot->odometry_sin, (way_right + way_left) / 2, 0.0,
        (way_right - way_left) / (2 * p->odometry_half_axle));
}

static double wrapped(double angle) { return angle - 2 * PI * floor((angle + PI) / (2 * PI)); }

/* Thesis (2.30) and (2.32) with the errors of (5.9). */
static Command lyapunov(const Gains *gains, const Pose *seen, const Reference *target) {
    double dx = target->x - seen->x, dy = target->y - seen->y;
    double c = cos(seen->heading), s = sin(seen->heading);
    double x = c * dx + s * dy, y = c * dy - s * dx, heading = wrapped(target->heading - seen->heading);
    double v = target->v * cos(heading) + gains->kx * x;
    double speed = greatest(fabs(target->v), least(fabs(v), gains->catch_up));
    return (Command){v, target->w + speed * (gains->ky * y + gains->kpsi * sin(heading))};
}

static Command within(const Parameters *p, Command command) {
    double v = clamp(command.v, p->v_max), w = clamp(command.w, p->w_max);
    double scale = least(1.0, p->wheel_max * p->radius / greatest(fabs(v) + p->half_axle * fabs(w), 1e-12));
    return (Command){v * scale, w * scale};
}

static void record(double *row, ptrdiff_t robots, const Parameters *p, const Robot *robot, Pose seen, Command order) {
    Command demand = within(p, order);
    double values[SAMPLES] = {
        robot->pose.x, robot->pose.y, robot->pose.heading, robot->v, robot->w, seen.x, seen.y, seen.heading,
        order.v, order.w, demand.v, demand.w, robot->effort, robot->variation,
    };
    for (int channel = 0; channel < SAMPLES; channel++) row[channel * robots] = values[channel];
}

/* Drive the runs from first to last - 1. Arrays are, in C order:
 * parameters (robots), starts and believed (runs, robots, 3), references (ticks + 1, robots),
 * noise (runs, ticks + 1, 3, robots), samples (runs, ticks + 1, SAMPLES, robots). Commands are `late` steps late. */
void drive(ptrdiff_t first, ptrdiff_t last, ptrdiff_t robots, ptrdiff_t ticks, ptrdiff_t late,
           const Parameters *parameters, const Pose *starts, const Pose *believed, const Reference *references,
           const double *noise, const Gains *gains, double *samples) {
    for (ptrdiff_t run = first; run < last; run++) {
        for (ptrdiff_t i = 0; i < robots; i++) {
            const Parameters *p = &parameters[i];
            Derived d = {1 / p->mass, 1 / p->inertia, 1 / p->radius, 1 / p->loop_radius, 1 / p->counts_per_radian,
                         p->friction_speed * p->friction_speed, p->ki / greatest(p->kp, 1e-12)};
            Robot robot = {.pose = starts[run * robots + i], .odometry = believed[run * robots + i]};
            Command orders[MOST_LATE + 1] = {{0}};
            ptrdiff_t periods = late / STEPS, rest = late % STEPS;
            for (ptrdiff_t k = 0; k <= ticks; k++) {
                ptrdiff_t sample = run * (ticks + 1) + k;
                const double *drawn = noise + sample * 3 * robots + i;
                Pose seen = robot.pose;
                seen.x += drawn[0];
                seen.y += drawn[robots];
                seen.heading += drawn[2 * robots];
                Command order = lyapunov(gains, &seen, &references[k * robots + i]);
                record(samples + sample * SAMPLES * robots + i, robots, p, &robot, seen, order);
                if (k == ticks) break;
                for (ptrdiff_t j = periods + 1; j > 0; j--) orders[j] = orders[j - 1];
                orders[0] = order;
                robot.cos_heading = cos(robot.pose.heading);
                robot.sin_heading = sin(robot.pose.heading);
                robot.odometry_cos = cos(robot.odometry.heading);
                robot.odometry_sin = sin(robot.odometry.heading);
                for (int j = 0; j < STEPS; j++) step(p, &d, &robot, j < rest ? orders[periods + 1] : orders[periods]);
            }
        }
    }
}
