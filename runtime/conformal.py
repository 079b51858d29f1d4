from .algebras import Algebra
class ConformalAlgebra(Algebra): pass
class ConformalPlane(Algebra): pass
