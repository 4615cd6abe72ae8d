"""What a demo found as one self-contained web page: figures, film strip, tables, commands."""

from rotorpong.lab.report.film import FilmFrame, film_strip
from rotorpong.lab.report.page import GENERATOR, report_page

__all__ = ["GENERATOR", "FilmFrame", "film_strip", "report_page"]
