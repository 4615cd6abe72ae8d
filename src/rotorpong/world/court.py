"""The court as data: table, net, room, in metres of the world frame.

The origin is the centre of the playing surface, x towards the opponent, y left, z up. Table, lines
and net are those of the ITTF rules; the room is an ordinary sports hall.
"""

from rotorpong.conventions import TABLE_HALF_LENGTH as TABLE_HALF_LENGTH
from rotorpong.conventions import TABLE_HALF_WIDTH as TABLE_HALF_WIDTH
from rotorpong.conventions import TABLE_HEIGHT

TABLE_THICKNESS = 0.025
EDGE_LINE_WIDTH = 0.020
CENTER_LINE_WIDTH = 0.003

NET_HEIGHT = 0.1525
NET_HALF_LENGTH = TABLE_HALF_WIDTH + 0.1525  # along y
NET_HALF_THICKNESS = 0.001
NET_TAPE_HEIGHT = 0.015
NET_CELL = 0.010  # the rules allow 7.5 to 12.5 mm
NET_CORD = 0.0012
POST_WIDTH = 0.022

LEG_X = 1.05  # distance of the leg frames from the net
LEG_Y = 0.55
LEG_WIDTH = 0.05

FLOOR_HEIGHT = -TABLE_HEIGHT
CEILING_HEIGHT = 3.3
ROOM_BACK = -5.0  # x of the wall behind the drone
ROOM_FRONT = 7.0  # x of the wall behind the opponent
ROOM_HALF_WIDTH = 4.0

OPPONENT_X = 2.9  # the plane in which the opponent stands
