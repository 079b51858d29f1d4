import pytest

from bladesmith.kinematics import load_urdf


@pytest.fixture
def load(tmp_path):
    def loaded(text, *arguments, **options):
        path = tmp_path / "robot.urdf"
        path.write_text(text)
        return load_urdf(path, *arguments, **options)

    return loaded
