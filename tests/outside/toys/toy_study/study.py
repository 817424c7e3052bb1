"""How many boxes there are."""

from dataclasses import dataclass, field

from steadyload.studies.kit import Study, option


@dataclass
class Found:
    boxes: int
    workers: int
    made_with: dict[str, str] = field(default_factory=dict)


class Toy(Study):
    """How many boxes."""

    name = "toy"
    answers = "How many boxes are there?"
    about = "count boxes"

    boxes: int = option(3, "how many boxes (default: 3)", least=1, most=9)

    def __post_init__(self):
        if self.boxes == 7:
            raise ValueError("boxes is 7; allowed: any but seven")

    def run(self, lab):
        lab.progress("counting", 1, 1)
        return Found(self.boxes, lab.workers)
