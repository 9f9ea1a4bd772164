"""ANFIS as a regressor of scikit-learn."""
