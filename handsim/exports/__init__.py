"""Movements handed on to what people use: pandas, Parquet, HDF5, LeRobot data sets, rerun.

In: rollouts, recordings and posture sequences, as objects or as files. Out: data frames, files and
folders that the libraries' own readers take. May import `viewing` and what lies below it; each
library is imported only where it is used.
"""
