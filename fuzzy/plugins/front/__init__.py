"""Rules from nothing: systems of few rules and of many, and how exact each of them is."""
