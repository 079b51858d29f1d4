"""TOML files with positions: every fault says file, line, key and remedy, also in awkward files."""

import re
import tomllib
from typing import Annotated, Literal

import pytest
from hypothesis import given
from hypothesis import strategies as st
from pydantic import Field, field_validator, model_validator

from bladesmith.codegen.documents.index import line_index, line_of
from bladesmith.common.documents import Document, Positive, Table, Vector3, read_document
from bladesmith.errors import InputError, SceneError, SpecError


class Sphere(Table):
    kind: Literal["sphere"]
    center: Vector3
    radius: Positive
    shininess: Annotated[float, Field(ge=1.0, le=1000.0)] = 1.0


class Plane(Table):
    kind: Literal["plane"]
    normal: Vector3 = (0.0, 0.0, 1.0)
    offset: float = 0.0

    @field_validator("normal")
    @classmethod
    def some_direction(cls, value):
        if value == (0.0, 0.0, 0.0):
            raise ValueError("a normal has a direction")
        return value


class Camera(Table):
    position: Vector3 = (0.0, 0.0, 0.0)
    look_at: Vector3 = (0.0, 1.0, 0.0)
    field_of_view: Positive = 45.0

    @model_validator(mode="after")
    def looks_somewhere(self):
        if self.position == self.look_at:
            raise ValueError("position and look_at are the same point")
        return self


class Scene(Table):
    camera: Camera = Camera()
    surfaces: list[Annotated[Sphere | Plane, Field(discriminator="kind")]] = []
    method: Literal["isolate", "companion", "sampled"] = "isolate"
    samples: int = 64
    names: dict[str, str] = {}


def message(text: str, error=SceneError) -> str:
    with pytest.raises(error) as caught:
        Document("tube.toml", text, Scene, error)
    assert "\n" not in str(caught.value)
    return str(caught.value)


SPHERE = '[[surfaces]]\nkind = "sphere"\ncenter = [0, 0, 0]\n'  # three lines, a radius is to follow


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        (SPHERE + "radius = -0.4", "tube.toml, line 4: surfaces[0].radius is -0.4; a radius is positive."),
        (SPHERE + "radius = 1\n" + SPHERE + "radius = 0",
         "tube.toml, line 8: surfaces[1].radius is 0; a radius is positive."),
        (SPHERE + "radius = 1\nshininess = 0.5",
         "tube.toml, line 5: surfaces[0].shininess is 0.5; a shininess is at least 1."),
        (SPHERE + "radius = 1\nshininess = 1e6",
         "tube.toml, line 5: surfaces[0].shininess is 1000000.0; a shininess is at most 1000."),
        (SPHERE + "radus = 1",
         "tube.toml, line 4: surfaces[0].radus is not a known key; did you mean 'radius'? (1 more fault.)"),
        (SPHERE, "tube.toml, line 1: surfaces[0] has no radius, which is required."),
        (SPHERE + "radius = '1'", 'tube.toml, line 4: surfaces[0].radius is "1"; a number is needed.'),
        (SPHERE + "radius = true", "tube.toml, line 4: surfaces[0].radius is true; a number is needed."),
        (SPHERE + "radius = inf", "tube.toml, line 4: surfaces[0].radius is inf; numbers are finite."),
        ('[[surfaces]]\nkind = "plane"\nnormal = [0,\n 0,\n -nan]',
         "tube.toml, line 5: surfaces[0].normal[2] is nan; numbers are finite."),
        ('[[surfaces]]\nkind = "plane"\nnormal = [0, 0, 0]',
         "tube.toml, line 3: surfaces[0].normal is [0, 0, 0]; a normal has a direction."),
        ('[[surfaces]]\nkind = "plane"\nnormal = [0, 1]',
         "tube.toml, line 3: surfaces[0].normal has 2 where 3 numbers are needed."),
        ('[[surfaces]]\nkind = "plane"\nnormal = [0]',
         "tube.toml, line 3: surfaces[0].normal has 1 where 3 numbers are needed."),
        ('[[surfaces]]\nkind = "plane"\nnormal = [0, 1, 2, 3]',
         "tube.toml, line 3: surfaces[0].normal is [0, 1, 2, 3]; it has 4 items where 3 are the most."),
        ('\n[[surfaces]]\n\nkind = "spere"',
         "tube.toml, line 4: surfaces[0].kind is \"spere\"; did you mean 'sphere'?"),
        ('[[surfaces]]\nkind = "torus"',
         'tube.toml, line 2: surfaces[0].kind is "torus"; known: sphere, plane.'),
        ("[[surfaces]]\nradius = 1", "tube.toml, line 1: surfaces[0] has no kind, which says what it is."),
        ("surfaces = 3", "tube.toml, line 1: surfaces is 3; an array is needed."),
        ("surfaces = [\n3]", "tube.toml, line 2: surfaces[0] is 3; a table is needed."),
        ("camera = 3", "tube.toml, line 1: camera is 3; a table is needed."),
        ("samples = 1.5", "tube.toml, line 1: samples is 1.5; a whole number is needed."),
        ("method = 'isolated'", "tube.toml, line 1: method is \"isolated\"; did you mean 'isolate'?"),
        ("method = 4", "tube.toml, line 1: method is 4; known: isolate, companion, sampled."),
        ("names.a = 1", "tube.toml, line 1: names.a is 1; text in quotation marks is needed."),
        ("names.a = 'x'\nnames.b = 1979-05-27\nnames.c = 2",
         "line 3: names.c is 2; text in quotation marks is needed."),
        ("lights = 1",
         "tube.toml, line 1: lights is not a known key; "
         "known keys: camera, surfaces, method, samples, names."),
        ("[camera]\nfield_of_veiw = 1",
         "line 2: camera.field_of_veiw is not a known key; did you mean 'field_of_view'?"),
        ("[camera]\nposition = [1, 1, 1]\nlook_at = [1, 1, 1]",
         "line 1: camera: position and look_at are the same point."),
        ("a = = 3", "tube.toml, line 1, column 5: invalid value."),
        ("\n\nx = [1", "tube.toml, end of document: unclosed array."),
        ("x = 1\nx = 2", "tube.toml, line 2, column 6: cannot overwrite a value."),
        ("x = " + "[" * 20000, "tube.toml: arrays or tables are nested too deeply."),
    ],
)  # fmt: skip
def test_message(text, expected):
    assert message(text).endswith(expected)


def test_the_class_of_the_error_is_chosen():
    for error in (SceneError, SpecError, InputError):
        assert type(pytest.raises(error, Document, "x", "samples = 1.5", Scene, error).value) is error


def test_a_good_file_is_read(tmp_path):
    path = tmp_path / "scene.toml"
    path.write_bytes(b"\xef\xbb\xbf" + (SPHERE + "radius = 2 # metres").replace("\n", "\r\n").encode())
    scene = read_document(path, Scene, SceneError).contents
    assert scene.surfaces == [Sphere(kind="sphere", center=(0.0, 0.0, 0.0), radius=2.0)]
    document = read_document(str(path), Scene, SceneError)
    assert document.contents == scene
    error = document.error(("surfaces", 0, "radius"), "is 2; the tube is thinner", "Use a smaller one.")
    assert str(error) == f"{path}, line 4: surfaces[0].radius is 2; the tube is thinner. Use a smaller one."


def test_files_that_cannot_be_read(tmp_path):
    (tmp_path / "latin.toml").write_bytes(b"x = 'caf\xe9'")
    for path, says in [
        (tmp_path / "none.toml", "No such file"),
        (tmp_path, "directory"),
        (tmp_path / "latin.toml", "UTF-8"),
    ]:
        with pytest.raises(SceneError, match=says) as caught:
            read_document(path, Scene, SceneError)
        assert str(path) in str(caught.value)


# In these texts every @ stands for the number of its own line: the parsed values say where each key is.

AWKWARD = '''# a comment with = [ { " '
title = "a # no comment, [no] {table}, \\" quoted = \\" \\\\"  # a comment
"quoted key" = @
'literal "key"' = @
"esc\\"aped \\u0041" = @
1234 = @
site."example.com".x = @
a . b . c = @
a.b.d = [ @, @,
   # between items ] }
   @
   , @ ]
empty = []
none = {}
multi = """
[not.a.table]
x = 3 \\""" still
two quotes at the end"""""
after_multi = @
literal = \'\'\'
[[neither]]
\'\'\'\'
after_literal = @
date = 1979-05-27 07:32:00Z # a date
after_date = @
float = [ 1e5, -inf, 0xDEAD_BEEF ]
matrix = [
  [@, @],
  [
    @,
    @,
  ],  # trailing comma
]
points = [ { x = @, y.z = @ }, { x = @ },
  {x=@,label="}, ]"} ]

[server]   # a header with a comment
port = @
[ server . "a.b" . c ]
port = @

[[fruits]]
name = @
[fruits.physical]
color = @
[[fruits.varieties]]
name = @
[[fruits.varieties]]
name = @
[fruits.varieties.deep]
x = @
[[fruits]]
name = @
  [[fruits.varieties]]
  name = @
[server.late]
x = @
[server.late.'it''s']
'''.replace("[server.late.'it''s']\n", '[server.late."it\'s"]\nx = @\n')


def numbered(text: str) -> str:
    return "\n".join(line.replace("@", str(i)) for i, line in enumerate(text.split("\n"), start=1))


def check_index(text: str) -> int:
    """Compare the index with the values of a text that says its own lines; the number of values compared."""
    text = numbered(text)
    index = line_index(text)
    compared = 0

    def visit(value, path):
        nonlocal compared
        if path:
            assert path in index, path
        if isinstance(value, dict):
            for key, item in value.items():
                visit(item, (*path, key))
        elif isinstance(value, list):
            for i, item in enumerate(value):
                visit(item, (*path, i))
        elif type(value) is int and value < 0xDEAD:
            assert index[path] == value, path
            compared += 1

    visit(tomllib.loads(text), ())
    return compared


@pytest.mark.parametrize("newline", ["\n", "\r\n"])
def test_awkward_file(newline):
    text = AWKWARD.replace("\n", newline)
    assert check_index(text) == AWKWARD.count("@")
    index = line_index(numbered(text))
    headers = [i for i, line in enumerate(AWKWARD.split("\n"), 1) if line.strip().startswith("[[fruits]]")]
    assert [index["fruits", i] for i in range(2)] == headers
    assert line_of(index, ("fruits", 1, "absent", "deeper")) == headers[1]
    assert line_of(index, ("absent",)) is None


noise = st.sampled_from(["", "# x = [ {\n", "\n", "\r\n", "  \n", "\t# '''\n"])
scalars = st.sampled_from(["@", "@ ", '"]"', "'}'", '"""\n]\\""" """', "'''\n#\n'''", "true", "1.5e3", "07:32:00"])
keys = st.sampled_from(["a", "b-c", '"d.e"', "'f\"'", '"\\u0067"', "h . i", "'[x]'.j"])
values = st.recursive(
    scalars,
    lambda inner: st.one_of(
        st.lists(st.tuples(noise, inner), max_size=4).map(
            lambda items: "[" + ",".join(f"{before}{item}{before}" for before, item in items) + "\n]"
        ),
        st.lists(inner.filter(lambda text: "\n" not in text), max_size=3).map(
            lambda items: "{" + ", ".join(f"k{i} = {item}" for i, item in enumerate(items)) + " }"
        ),
    ),
    max_leaves=8,
)
pairs = st.lists(st.tuples(keys, values, noise), unique_by=lambda pair: pair[0], max_size=4).map(
    lambda found: "".join(f"{key} = {value}\n{after}" for key, value, after in found)
)
headers = st.sampled_from(["[[t]]", "[[t.u]]", "[[ 't' . \"u\" ]] # [x]", "[[v]]"])


@pytest.mark.slow
@given(pairs, st.lists(st.tuples(headers, pairs), max_size=6))
def test_random_files(top, tables):
    text = top + "".join(f"{header}\n{body}" for header, body in tables)
    try:
        tomllib.loads(text.replace("@", "0"))
    except tomllib.TOMLDecodeError:
        return  # a table of tables declared before its parent, and the like
    check_index(text)


@given(st.text(alphabet="ab.=[]{}\"'#\n, 1@\\", max_size=40))
def test_any_text_gives_contents_or_an_error(text):
    """Whatever the text, the answer is a document or an InputError, never another exception."""
    try:
        Document("any.toml", text, Scene, SceneError)
    except SceneError as error:
        assert re.match(r"any\.toml(, line \d+|, end of document)?", str(error))
