"""From pictures to the ball: detect, measure, locate; reads calibration files and pictures."""

from rotorpong.vision.calibration import read_camera
from rotorpong.vision.detect import Detection, detect
from rotorpong.vision.locate import ball_position
from rotorpong.vision.paper_eyes import PaperEyes
from rotorpong.vision.pictures import detect_pictures

__all__ = ["Detection", "PaperEyes", "ball_position", "detect", "detect_pictures", "read_camera"]
