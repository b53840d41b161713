"""Objects, human grasps, handover trials: files with provenance and schema, no algorithms."""

from medkit.datasets.folder import load_folder as load_folder

# Ratings of robot-to-human handovers.
from medkit.datasets.handover_trials import handover_anomalies as handover_anomalies
from medkit.datasets.handover_trials import human_references as human_references
from medkit.datasets.handover_trials import load_handover_table as load_handover_table

# Recordings of people grasping.
from medkit.datasets.human_grasps import FINGERS as FINGERS
from medkit.datasets.human_grasps import SENSORS as SENSORS
from medkit.datasets.human_grasps import human_grasps_folder as human_grasps_folder
from medkit.datasets.human_grasps import load_human_grasps as load_human_grasps
from medkit.datasets.human_grasps import load_human_objects as load_human_objects

# Objects made by code, and the user's own folder of them.
from medkit.datasets.objects import ObjectInfo as ObjectInfo
from medkit.datasets.objects import load_object as load_object
from medkit.datasets.objects import object_info as object_info
from medkit.datasets.objects import object_names as object_names
from medkit.datasets.printed import load_printed as load_printed
from medkit.datasets.printed import printed_names as printed_names
