"""The robot and what moves it: parameters, and the plant."""
