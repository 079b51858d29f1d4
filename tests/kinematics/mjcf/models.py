"""Models that have what MJCF has, for tests beside MuJoCo."""

#: Nested defaults, classes by body, orientations of every kind, several joints in a body, references, frames, geoms.
ARM = """
<mujoco model="arm">
  <compiler eulerseq="zYx" inertiafromgeom="auto"/>
  <default>
    <joint axis="0 1 0" ref="10"/>
    <geom density="500" size="0.1"/>
    <default class="wide">
      <joint axis="1 1 0" range="-40 60"/>
      <geom type="box" size="0.1 0.2 0.3"/>
      <default class="flat"><geom size="0.3 0.2 0.01" euler="10 20 30"/><joint limited="false"/></default>
    </default>
  </default>
  <worldbody>
    <light pos="0 0 3"/>
    <geom type="plane" size="1 1 1"/>
    <site name="hook" pos="0.3 0.2 2" euler="10 20 30"/>
    <body name="trunk" pos="0.1 0.2 1" euler="30 -20 50" childclass="wide">
      <joint name="turn" pos="0.1 0 0.2"/>
      <joint name="lift" type="slide" axis="0 0 2" ref="0.3" range="-1 2"/>
      <joint name="roll" axis="0 0 1" pos="0 0.3 0"/>
      <geom/>
      <geom type="capsule" fromto="0 0 0 0.4 0.2 0.7" size="0.05" class="main"/>
      <frame pos="0.2 0 0" axisangle="0 1 1 40">
        <geom class="flat" pos="0.1 0.1 0"/>
        <body name="arm" pos="0.5 0 0" quat="0.1 0.7 -0.5 0.5">
          <joint name="elbow" class="flat"/>
          <inertial pos="0.1 0 0.2" quat="0.5 0.1 -0.7 0.5" mass="2" diaginertia="0.1 0.2 0.25"/>
          <geom/>
          <body pos="0 0.4 0" xyaxes="1 1 0 0 1 1">
            <joint name="ball" type="ball" pos="0.1 0.1 0.1" class="main"/>
            <geom type="cylinder" size="0.1 0.4" mass="3"/>
            <body zaxis="1 2 -3"><geom type="ellipsoid" size="0.1 0.2 0.3"/><geom type="sphere" pos="1 0 0"/></body>
          </body>
        </body>
      </frame>
    </body>
    <body name="loose" pos="3 0 1" zaxis="0 1 1"><freejoint name="free"/><geom type="box" size="1 2 3" mass="1"/>
      <body><joint type="slide"/><inertial pos="0 0 0" mass="1" fullinertia="0.3 0.4 0.5 0.01 -0.02 0.03"/></body>
    </body>
  </worldbody>
</mujoco>
"""
#: A four-bar linkage, closed by a point; a finger that follows; a weld.
LOOP = """
<mujoco>
  <compiler angle="radian"/>
  <worldbody>
    <body name="crank" pos="0 0 0">
      <joint name="crank" axis="0 1 0" ref="0.5"/><geom type="capsule" size="0.02" fromto="0 0 0 0 0 1"/>
      <body name="coupler" pos="0 0 1">
        <joint name="pin" axis="0 1 0"/><geom type="capsule" size="0.02" fromto="0 0 0 2 0 0"/>
        <site name="tip" pos="2 0 0"/>
        <body name="badge" pos="1 0 0"><geom size="0.1"/></body>
      </body>
    </body>
    <body name="rocker" pos="2 0 0">
      <joint name="rocker" axis="0 1 0"/><geom type="capsule" size="0.02" fromto="0 0 0 0 0 1"/>
      <site name="top" pos="0 0 1"/>
    </body>
    <body name="finger" pos="0 3 0"><joint name="finger" type="slide" axis="0 1 0" ref="0.1"/><geom size="0.1"/></body>
    <body name="held" pos="5 0 0"><joint name="held" axis="0 0 1" ref="0.3"/><geom size="0.1"/></body>
  </worldbody>
  <equality>
    <connect name="joint" body1="coupler" body2="rocker" anchor="2 0 0"/>
    <joint joint1="finger" joint2="crank" polycoef="0.2 -3"/>
    <joint joint1="held" polycoef="0.1"/>
    <connect body1="crank" anchor="0 0 0" active="false"/>
  </equality>
</mujoco>
"""
