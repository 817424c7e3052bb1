"""A study of another distribution: one folder."""

from dataclasses import dataclass

from steadyload.config import option
from steadyload.studies.study import Study


@dataclass(frozen=True)
class ToyConfig:
    boxes: int = option(3, "how many boxes (default: 3)", least=1, most=9)

    def __post_init__(self):
        if self.boxes == 7:
            raise ValueError("boxes is 7; allowed: any but seven")


class Toy(Study):
    name = "toy"
    question = "How many boxes are there?"
    about = "count boxes"
    Config = ToyConfig

    def run(self, config, work, *, workers=1, progress=None):
        progress("counting", 1, 1)
        return config.boxes, workers

    def page(self, result):
        from steadyload.reports.pages.page import Page, Section

        boxes, workers = result
        summary = f"There are {boxes} boxes. They were counted by {workers}."
        return Page("Boxes", summary, [Section("Boxes")], {})


STUDY = Toy()
