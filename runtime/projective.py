from .algebras import Algebra
class ProjectiveAlgebra(Algebra): pass
