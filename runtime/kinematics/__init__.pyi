from ..mechanics.joints.base import (
    Joint as Joint,
)
from ..mechanics.joints.bilinear import (
    Bilinear as Bilinear,
)
from ..mechanics.joints.bilinear import (
    Universal as Universal,
)
from ..mechanics.joints.standard import (
    Cylindrical as Cylindrical,
)
from ..mechanics.joints.standard import (
    Planar as Planar,
)
from ..mechanics.joints.standard import (
    Prismatic as Prismatic,
)
from ..mechanics.joints.standard import (
    Revolute as Revolute,
)
from ..mechanics.joints.standard import (
    Rigid as Rigid,
)
from ..mechanics.joints.standard import (
    Screw as Screw,
)
from ..mechanics.joints.standard import (
    Spherical as Spherical,
)
from .delta.robot import (
    DeltaRobot as DeltaRobot,
)
from .delta.trajectory import (
    Motion as Motion,
)
from .delta.workspace import (
    Workspace as Workspace,
)
from .io.reader import (
    load_mechanism as load_mechanism,
)
from .mechanism.jacobian import (
    Analysis as Analysis,
)
from .mechanism.mechanism import (
    Mechanism as Mechanism,
)
from .mechanism.mobility import (
    FreeMotion as FreeMotion,
)
from .mechanism.mobility import (
    SelfStress as SelfStress,
)
from .mechanism.poses.batch import (
    Poses as Poses,
)
from .mjcf.reader import (
    load_mjcf as load_mjcf,
)
from .mjcf.writer import (
    save_mjcf as save_mjcf,
)
from .plotting.picture import (
    picture as picture,
)
from .robots.robot import (
    Robot as Robot,
)
from .sdf.reader import (
    load_sdf as load_sdf,
)
from .serial.axes import (
    prismatic_axis as prismatic_axis,
)
from .serial.axes import (
    revolute_axis as revolute_axis,
)
from .serial.axes import (
    screw_axis as screw_axis,
)
from .serial.chain import (
    Chain as Chain,
)
from .serial.inverse import (
    Solution as Solution,
)
from .serial.singularity import (
    Singularity as Singularity,
)
from .solutions.postures import (
    Postures as Postures,
)
from .task.joint_trajectory import (
    load_motion as load_motion,
)
from .task.task import (
    Setup as Setup,
)
from .task.time_scaling import (
    TimedPath as TimedPath,
)
from .task.time_scaling import (
    time_optimal as time_optimal,
)
from .urdf.reader import (
    load_urdf as load_urdf,
)
from .urdf.reader import (
    urdf_example as urdf_example,
)
