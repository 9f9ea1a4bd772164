#include "NAME_control.h"

#include <stdio.h>

int main(int count, char **names) {
    REAL given[3], u;
    NAME_controller c;
    FILE *in = count == 3 ? fopen(names[1], "rb") : NULL, *out = count == 3 ? fopen(names[2], "wb") : NULL;
    if (in == NULL || out == NULL) return 2;
    NAME_begin(&c);
    while (fread(given, sizeof given, 1, in) == 1) {
        u = NAME_control(&c, GIVEN);
        if (fwrite(&u, sizeof u, 1, out) != 1) return 3;
    }
    return fclose(in) != 0 || fclose(out) != 0 ? 4 : 0;
}
