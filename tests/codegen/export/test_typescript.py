"""Declarations of exported JavaScript: TypeScript's compiler takes them, and refuses what they do not allow."""

from __future__ import annotations

import shutil
import subprocess
from pathlib import Path

import pytest

from bladesmith.codegen.export.export import export
from bladesmith.codegen.export.options import ExportOptions
from bladesmith.codegen.library.kernels import stock_variant
from bladesmith.kinematics import DeltaRobot, load_urdf
from bladesmith.kinematics.urdf.reader import urdf_example

from ...support.export.algorithms import everything, total
from ...support.export.small import algorithm_to_export, shifted

TSC = ["tsc", "--strict", "--noEmit", "--module", "nodenext", "--target", "es2022"]
PROGRAM = """
import { logMotorMotor, expBivectorTwist, type LogMotorMotorResult, type Line, type Motor } from "./pga3d.mjs";
import * as cga from "./cga3d.mjs";
import * as arm from "./arm.mjs";
import { inverse } from "./delta.mjs";
import { total } from "./total.mjs";
import * as everything from "./everything.mjs";
import { shifted } from "./shifted.mjs";

const b: Line = { e01: 0, e02: 0, e03: 1, e12: 0.5, e13: 0, e23: 0 };
const m: Motor = expBivectorTwist(b);
const r: LogMotorMotorResult = logMotorMotor(m);
const code: number = r.status, part: number = r.out.e12;
const q = new Float64Array(6), matrix: number[] = [];
arm.motor(q, new Float64Array(8));
arm.matrix(q, matrix);
arm.jacobian([0, 0, 0, 0, 0, 0], new Float64Array(36));
inverse([0, 0, 0], [0], [0.0, 0.0, 0.8]);
const [sum, count, some]: [number, number, boolean] = total([1, 2, 3], 0);
const nothing: void = shifted(matrix, 1);
// @ts-expect-error: a motor has more fields
expBivectorTwist({ e12: 1 });
// @ts-expect-error: a result is no text
const text: string = logMotorMotor(m).status;
// @ts-expect-error: what is written is no readonly array
arm.matrix(q, [0] as readonly number[]);
// @ts-expect-error: there is no such function
cga.nothing();
export { code, part, sum, count, some, nothing, text, everything };
"""


@pytest.mark.slow
@pytest.mark.skipif(shutil.which("tsc") is None, reason="no tsc (npm: typescript)")
def test_a_program_that_uses_the_declarations_is_valid(tmp_path: Path) -> None:
    for algebra in ("pga3d", "cga3d"):
        names = ("exp_bivector_twist", "log_motor_motor", "sandwich_motor_point", "normalise_vector")
        export([stock_variant(algebra, name) for name in names], tmp_path, ExportOptions("js", algebra))
    for algorithm in (total, everything, shifted):
        item = algorithm_to_export(algorithm)
        export([item], tmp_path, ExportOptions("js", item.name))
    load_urdf(urdf_example("arm")).export("js", tmp_path, "arm")
    DeltaRobot(0.4, 0.1, 0.5, 1.0).export("js", tmp_path)
    (tmp_path / "main.mts").write_text(PROGRAM)
    found = subprocess.run([*TSC, "main.mts"], cwd=tmp_path, capture_output=True, text=True, check=False)
    assert found.returncode == 0, found.stdout
