"""Files: MATLAB's .fis, tables of numbers, and writing whole or not at all."""
