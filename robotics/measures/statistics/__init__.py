"""The statistics of a fair comparison of controllers: arrays of costs in, numbers with their intervals out.

Costs are arrays (laws, scenarios, seeds), and smaller is better. They are paired: at the same scenario and seed every
law met the same start and the same noise. A run that failed, because its robot was stopped or left its path, costs
infinity. Scenarios are the strata: they are fixed, and only the seeds are drawn anew. What an interval says is
therefore about these scenarios with other seeds, and not about other scenarios.
"""
