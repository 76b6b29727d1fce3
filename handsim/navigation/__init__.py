"""The mathematics: splines, obstacle, metric, navigation function, its flow and its certificate.

In: knots and coefficients. Out: values, gradients and paths in the subspace, and the proof that all
paths arrive. May import nothing but the modules beside the rooms; it knows neither recordings nor
hands.
"""
