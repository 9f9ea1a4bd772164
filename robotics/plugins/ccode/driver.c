#include "NAME.h"

#include <stdio.h>

int main(int count, char **names) {
    NAME_state state;
    NAME_input input;
    NAME_output output;
    FILE *in = count == 3 ? fopen(names[1], "rb") : NULL, *out = count == 3 ? fopen(names[2], "wb") : NULL;
    if (in == NULL || out == NULL) return 2;
    NAME_init(&stateFIRST);
    while (fread(&input, sizeof input, 1, in) == 1) {
        if (!NAME_step(&state, &input, &output)) return 3;
        if (fwrite(&output, sizeof output, 1, out) != 1) return 4;
    }
    return fclose(in) != 0 || fclose(out) != 0 ? 5 : 0;
}
