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
from .mechanism.poses import (
    Poses as Poses,
)
from .plotting.picture import (
    picture as picture,
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
from .task.joint_trajectory import (
    load_motion as load_motion,
)
from .task.task import (
    Setup as Setup,
)
from .urdf.robot import (
    Robot as Robot,
)
from .urdf.robot import (
    load_urdf as load_urdf,
)
from .urdf.robot import (
    urdf_example as urdf_example,
)
