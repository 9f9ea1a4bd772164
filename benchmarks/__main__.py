"""Every benchmark, one after the other."""

from benchmarks import avoidance, closedloop, designer, environments, inference, learning, predictive, ros, simulation

if __name__ == "__main__":
    inference.main()
    print()
    simulation.main()
    print()
    closedloop.main()
    print()
    learning.main()
    print()
    predictive.main()
    print()
    avoidance.main()
    print()
    environments.main()
    print()
    designer.main()
    print()
    ros.main()
