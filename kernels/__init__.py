"""The kernels that a platform's wheel brings: compiled here, by the commands and scripts that users begin with."""
