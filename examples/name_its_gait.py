"""Let a champion swim, and name its gait.  No ROS; SciPy: pip install 'evodevo_sim[gaits]'.

    python examples/name_its_gait.py [NAME]
"""

import sys

from evodevo_sim.analysis.gait import analyse, track_of_performance

from evodevo_sim import Task, load_champion, perform

task = Task()
performance = perform(load_champion(sys.argv[1] if len(sys.argv) > 1 else "undulator"), task)
gait = analyse(track_of_performance(performance, task)).gait
print(f"{gait.name}: {gait.why}")
print(f"{gait.frequency:.2f} Hz, {gait.speed:.2f} m/s, cost of transport {gait.cost_of_transport:.1f} J/(kg m)")
