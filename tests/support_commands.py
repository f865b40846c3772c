"""What tests of whole commands need: parameters of planar2r, a URDF, limits for excite."""

PARAMETERS = "[parameters]\nZZ1R = 3.5\nZZ2 = 0.06\nMX2 = 0.124\nMY2 = 0.006\n"
URDF = """<robot name="one"><link name="a"/><link name="b"><inertial><mass value="1"/>
<inertia ixx="1" ixy="0" ixz="0" iyy="1" iyz="0" izz="1"/></inertial></link>
<joint name="j" type="revolute"><parent link="a"/><child link="b"/><axis xyz="0 0 1"/>
<limit effort="1" velocity="1" lower="-1" upper="1"/></joint></robot>
"""
LIMITS = "--position 1 --velocity 2 --acceleration 8 --torque 100".split()
LOADED = "[parameters]\nZZ1R = 4.0\nZZ2 = 0.24\nMX2 = 0.724\nMY2 = 0.006\n"  # 2 kg at 0.3 m
