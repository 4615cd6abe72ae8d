"""The constants of the profile `tum_gazebo`; its equations are in `vehicle`."""

from typing import NamedTuple


class Cascade(NamedTuple):
    """Constants of the rigid body and its loops, all floats.

    Sources: `simple` = quadrotor_simple_controller and its xacro, `imu` = gazebo_ros_imu and
    quadrotor_sensors.urdf.xacro, `base` = quadrotor_base.urdf.xacro of tum_simulator.

    The attitude noise is what `imu` means: an accelerometer error e tilts gravity g by e / g, 2
    degrees of white noise. As written, the plugin turns by the square of that angle (it scales the
    cross product g x e, itself of size g e, by half the angle): 0.2 degrees rms of both axes, see
    the row of `lab.bench.vehicle_rows`. The design decides for the 2 degrees, which a player must
    then filter with the gyro; `TUM_RANGES` reaches from one to the other.
    """

    mass: float = 1.477  # kg, base
    inertia_x: float = 0.01152  # kg m^2, base
    inertia_y: float = 0.01152
    inertia_z: float = 0.0218
    gravity: float = 9.8  # m/s^2, Gazebo's
    thrust_limit: float = 30.0  # N, simple
    horizontal_p: float = 5.0  # 1/s, simple, as all loops below
    horizontal_d: float = 1.0
    horizontal_limit: float = 2.0  # m/s
    vertical_p: float = 5.0  # 1/s
    vertical_d: float = 1.0
    vertical_limit: float = 0.5  # m/s
    tilt_p: float = 10.0  # 1/s^2
    tilt_d: float = 5.0  # 1/s
    tilt_limit: float = 0.5  # rad
    yaw_p: float = 2.0  # 1/s
    yaw_d: float = 1.0
    yaw_limit: float = 1.5  # rad/s
    sample_ticks: float = 10.0  # state and imu at 100 Hz
    attitude_noise: float = 0.35 / 9.8  # rad, white in each sample: accelerometer noise over g, imu
    command_white: float = 0.05  # m/s and rad/s, uniform +-, anew for each message, simple
    command_offset: float = 0.03  # m/s and rad/s, uniform +-, anew every period, simple
    command_offset_period: float = 5.0  # s


TUM_CASCADE = Cascade()
NOISE_FREE_CASCADE = Cascade(attitude_noise=0.0, command_white=0.0, command_offset=0.0)
