"""Runtime: a policy on a robot, without Gymnasium and without the simulator.

- ``controller``: ``SpeedController``, from readings by name to a commanded speed
- ``readings``: the checks of a robot's readings, and the observation that they make
- ``people``: tracked people, and the walking patterns of the encounters
- ``robot_file``: the robot as a YAML file, and whether a policy was made for it
"""
