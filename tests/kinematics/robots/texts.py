"""Texts of small robots."""


def robot(body, name="robot"):
    return f'<robot name="{name}">{body}</robot>'


def joint(name="j", kind="revolute", parent="a", child="b", inside='<axis xyz="0 0 1"/>'):
    return f'<joint name="{name}" type="{kind}"><parent link="{parent}"/><child link="{child}"/>{inside}</joint>'


def link(name, mass=None, moments=(1.0, 1.0, 1.0), origin="", products=(0.0, 0.0, 0.0)):
    if mass is None:
        return f'<link name="{name}"/>'
    names = ("ixx", "iyy", "izz", "ixy", "ixz", "iyz")
    words = " ".join(f'{k}="{v!r}"' for k, v in zip(names, (*moments, *products), strict=True))
    return f'<link name="{name}"><inertial>{origin}<mass value="{mass}"/><inertia {words}/></inertial></link>'
