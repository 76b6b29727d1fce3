"""What both learners share: splines as linear functions of coefficients, and minimisation.

May import `navigation`. All arithmetic is that of `handsim.reproducible`.
"""
