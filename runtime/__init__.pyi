from . import codegen as codegen
from . import curves as curves
from . import dynamics as dynamics
from . import errors as errors
from . import interchange as interchange
from . import kinematics as kinematics
from . import mechanics as mechanics
from . import objects as objects
from . import plot as plot
from . import poses as poses
from . import reform as reform
from . import registration as registration
from . import tracer as tracer
from .codegen.progress import Progress as Progress
from .codegen.version import __version__ as __version__
from .common.parallel import set_threads as set_threads
from .core.formatting import print_options as print_options
from .core.formatting import set_print_options as set_print_options
from .core.geometry.conformal import ConformalAlgebra as ConformalAlgebra
from .core.geometry.conformal import ConformalPlane as ConformalPlane
from .core.geometry.presets import DoubleConformalAlgebra as DoubleConformalAlgebra
from .core.geometry.presets import PlaneVectors as PlaneVectors
from .core.geometry.presets import QuadricAlgebra as QuadricAlgebra
from .core.geometry.presets import Spacetime as Spacetime
from .core.geometry.presets import SpaceVectors as SpaceVectors
from .core.geometry.projective import ProjectiveAlgebra as ProjectiveAlgebra
from .core.geometry.projective import ProjectivePlane as ProjectivePlane
from .core.multivector import Algebra as Algebra
from .core.multivector import Multivector as Multivector
from .core.registry import algebra as algebra
from .core.registry import load_algebra as load_algebra
from .core.storage import load as load
from .core.storage import save as save
from .interchange.clifford import from_clifford as from_clifford
from .status import Status as Status

cga3d: ConformalAlgebra
cga2d: ConformalPlane
pga3d: ProjectiveAlgebra
pga2d: ProjectivePlane
vga2d: PlaneVectors
vga3d: SpaceVectors
sta: Spacetime
qcga: QuadricAlgebra
dcga: DoubleConformalAlgebra
