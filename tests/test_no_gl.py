"""No part of the product loads a library for graphics hardware or a display."""

import re
import subprocess
import sys

GL_LIBRARY = re.compile(
    r"/(?:lib(?:GL|EGL|OSMesa|glapi|gbm|vulkan|X11|Qt)[\w-]*\.so|[\w-]+_dri\.so)[.\w]*"
)
USE = """
import io
import cv2, matplotlib, numpy as np
matplotlib.use("Agg")
from matplotlib import pyplot
from rotorpong.conventions import CAMERA_FROM_BODY_AXES
from rotorpong.physics.camera import GAZEBO
from rotorpong.vision.detect import detect
from rotorpong.world.render import Scene, render
ball = np.array([0.5, 0.0, 0.3])
picture = render(GAZEBO, np.array([-1.7, 0.0, 0.2]), CAMERA_FROM_BODY_AXES.T.copy(), ball, Scene())
assert detect(picture)
cv2.imencode(".png", picture)
pyplot.imshow(picture)
pyplot.savefig(io.BytesIO())
try:
    print(open("/proc/self/maps").read())
except FileNotFoundError:
    pass  # not Linux
"""


def test_rendering_seeing_and_plotting_load_no_gl():
    result = subprocess.run([sys.executable, "-c", USE], capture_output=True, text=True)
    assert result.returncode == 0, result.stderr
    assert GL_LIBRARY.findall(result.stdout) == []


def test_the_search_tells_gl_from_harmless_libraries():
    found = "/usr/lib/libGL.so.1.7.0 /lib/libEGL_mesa.so.0 /lib/dri/swrast_dri.so /x/libGLX.so.0"
    assert len(GL_LIBRARY.findall(found)) == 4
    harmless = "/x/pillow.libs/libxcb-6c.so.1 /x/av.libs/libdrm-1.so.2 /lib/libglib-2.0.so.0"
    assert GL_LIBRARY.findall(harmless) == []
