"""Many laws on one scenario at once: candidates times seeds, each law with gains, a rule base and robots of its own.

Laws of one equation are driven side by side, their gains as columns: a thousand candidates are one pass, and every run
has, to the last bit, the result that it has alone.
"""
