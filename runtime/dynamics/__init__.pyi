from ..mechanics.chart_maps import (
    map_motor as map_motor,
)
from ..mechanics.chart_maps import (
    map_rate as map_rate,
)
from ..mechanics.inertia import (
    Inertia as Inertia,
)
from ..mechanics.mass_properties import (
    mass_properties as mass_properties,
)
from ..mechanics.rigid_body import (
    RigidBody as RigidBody,
)
from ..mechanics.screws import (
    couple as couple,
)
from ..mechanics.screws import (
    killing_form as killing_form,
)
from ..mechanics.screws import (
    moment_about as moment_about,
)
from ..mechanics.screws import (
    power as power,
)
from ..mechanics.screws import (
    reciprocal as reciprocal,
)
from ..mechanics.screws import (
    screw as screw,
)
from ..mechanics.screws import (
    screw_coordinates as screw_coordinates,
)
from ..mechanics.screws import (
    screw_cross as screw_cross,
)
from ..mechanics.screws import (
    screw_from_coordinates as screw_from_coordinates,
)
from ..mechanics.screws import (
    twist as twist,
)
from ..mechanics.screws import (
    twist_parts as twist_parts,
)
from ..mechanics.screws import (
    velocity_at as velocity_at,
)
from ..mechanics.screws import (
    wrench as wrench,
)
from ..mechanics.screws import (
    wrench_parts as wrench_parts,
)
from ..mechanics.shapes import (
    Shape as Shape,
)
from ..mechanics.shapes import (
    box as box,
)
from ..mechanics.shapes import (
    cone as cone,
)
from ..mechanics.shapes import (
    cylinder as cylinder,
)
from ..mechanics.shapes import (
    rod as rod,
)
from ..mechanics.shapes import (
    sphere as sphere,
)
from ..mechanics.statics import (
    equilibrium as equilibrium,
)
from ..mechanics.statics import (
    force_along as force_along,
)
from ..mechanics.statics import (
    ideal_line as ideal_line,
)
from ..mechanics.statics import (
    line_of_wrench as line_of_wrench,
)
from ..mechanics.statics import (
    resultant as resultant,
)
from ..mechanics.statics import (
    vector_of_wrench as vector_of_wrench,
)
from ..mechanics.statics import (
    wrench_of_vector as wrench_of_vector,
)
from ..mechanics.system import (
    System as System,
)
from ..mechanics.units import (
    Units as Units,
)
from .allowed_twists import (
    allowed_twists as allowed_twists,
)
from .integration.events import (
    Event as Event,
)
from .io.reader import (
    Setup as Setup,
)
from .io.reader import (
    load_simulation as load_simulation,
)
from .model.constraints import (
    Incidence as Incidence,
)
from .model.constraints import (
    Pin as Pin,
)
from .model.constraints import (
    PinLinear as PinLinear,
)
from .model.constraints import (
    PinPath as PinPath,
)
from .model.constraints import (
    VirtualPower as VirtualPower,
)
from .model.joint_loads import (
    JointDamper as JointDamper,
)
from .model.joint_loads import (
    JointFriction as JointFriction,
)
from .model.joint_loads import (
    JointLimit as JointLimit,
)
from .model.joint_loads import (
    JointSpring as JointSpring,
)
from .model.joint_loads import (
    JointTorque as JointTorque,
)
from .model.loads import (
    BodyWrench as BodyWrench,
)
from .model.loads import (
    Damper as Damper,
)
from .model.loads import (
    Gravity as Gravity,
)
from .model.loads import (
    QuadraticDrag as QuadraticDrag,
)
from .model.loads import (
    Spring as Spring,
)
from .model.loads import (
    WorldWrench as WorldWrench,
)
from .plotting.animation import (
    animate as animate,
)
from .plotting.curves import (
    plot as plot,
)
from .plotting.scene import (
    picture as picture,
)
from .record import (
    Record as Record,
)
from .record import (
    as_record as as_record,
)
from .record import (
    load_trajectory as load_trajectory,
)
from .results.figure_spec import (
    Sketch as Sketch,
)
from .results.figure_spec import (
    Trace as Trace,
)
from .results.trajectory_files import (
    save as save,
)
from .simulation import (
    Simulation as Simulation,
)
from .trajectory import (
    Trajectory as Trajectory,
)
