from .closest_points import (
    closest_point as closest_point,
)
from .clustering.agglomerative import (
    merge_similar as merge_similar,
)
from .clustering.kmeans import (
    kmeans as kmeans,
)
from .enclosing import (
    enclosing_sphere as enclosing_sphere,
)
from .fitting.fits import (
    fit_circle as fit_circle,
)
from .fitting.fits import (
    fit_line as fit_line,
)
from .fitting.fits import (
    fit_plane as fit_plane,
)
from .fitting.fits import (
    fit_sphere as fit_sphere,
)
from .interpolation.blending import (
    align as align,
)
from .interpolation.blending import (
    average as average,
)
from .interpolation.blending import (
    interpolate as interpolate,
)
from .interpolation.blending import (
    interpolate_derivative as interpolate_derivative,
)
from .interpolation.blending import (
    project_to_blade as project_to_blade,
)
from .interpolation.sphere_weights import (
    sphere_weights as sphere_weights,
)
from .rotors.between import (
    mirror_between as mirror_between,
)
from .rotors.between import (
    rotor_between as rotor_between,
)
from .rotors.between import (
    trs_rotor as trs_rotor,
)
from .rotors.costs import (
    cost_matrix as cost_matrix,
)
from .rotors.costs import (
    rotor_cost as rotor_cost,
)
from .screws import (
    screw as screw,
)
from .screws import (
    screw_bivector as screw_bivector,
)
from .screws import (
    screw_motor as screw_motor,
)
from .screws import (
    screw_of_lines as screw_of_lines,
)
from .spheres import (
    common_sphere as common_sphere,
)
from .spheres import (
    orthogonal_sphere as orthogonal_sphere,
)
from .subspaces.join_meet import (
    factorise as factorise,
)
from .subspaces.join_meet import (
    factorize as factorize,
)
from .subspaces.join_meet import (
    is_blade as is_blade,
)
from .subspaces.join_meet import (
    join as join,
)
from .subspaces.join_meet import (
    meet as meet,
)
