"""What is searched on an engine, and parameter sets made from tuned ones."""

import dataclasses

import numpy as np
import pytest

from steadyload.engines.registry import capabilities, engine_names
from steadyload.engines.world import SETTINGS, Support, WorldSettings
from steadyload.methods.contract.spec import as_plain
from steadyload.methods.registry import make_method
from steadyload.methods.simulation.simulation_parameters import SimulationParameters
from steadyload.studies.tuning.comparing import carried_over, physical, without_gains
from steadyload.tuning import TuningError
from steadyload.tuning.space import gene_groups, space_names, space_on

TUNABLE = [name for name in engine_names() if not capabilities(name).error_controlled]

PRINTED = {
    "eps_t": (1, 100, 1),
    "eps_r": (5, 15, 1),
    "t_max": (0.1, 3, 0.1),
    "frequency": (5, 100, 5),
    "restitution": (0.05, 0.2, 0.01),
    "friction": (0.4, 0.6, 0.01),
    "linear_damping": (0.01, 0.2, 0.05),
    "angular_damping": (0.01, 0.2, 0.05),
    "margin": (0.001, 0.02, 0.001),
}
"""Table 3 of the paper: least, most, step."""

FOUND = {
    "eps_t": 22, "eps_r": 7, "t_max": 0.3, "frequency": 90, "restitution": 0.11, "friction": 0.5,
    "linear_damping": 0.06, "angular_damping": 0.01, "margin": 0.006, "broad_phase": "dbvt",
}  # fmt: skip
"""Table 3 of the paper: what its search found."""


@pytest.fixture(params=TUNABLE)
def tunable(request):
    return request.param


def has_effect(engine, name, value):
    """Whether an engine does anything with a setting at a value."""
    asked = WorldSettings(**{name: value})
    return capabilities(engine).support(name, asked) in (Support.HONOURED, Support.EMULATED)


@pytest.mark.parametrize("name", space_names())
def test_genes_are_those_that_have_an_effect_on_the_engine(tunable, name):
    genes = {gene.name: gene.values for gene in space_on(tunable, name).genes}
    for gene in genes.keys() & set(SETTINGS):
        assert all(has_effect(tunable, gene, value) for value in genes[gene]), gene
    own = make_method(f"simulation@{tunable}").parameters
    assert genes.keys() <= {field.name for field in dataclasses.fields(own)}
    # Nothing is left out that has an effect: values that other engines are searched over.
    everywhere = {g.name: g.values for engine in TUNABLE for g in space_on(engine, name).genes}
    for gene, values in everywhere.items():
        missing = gene not in genes
        if gene in SETTINGS:
            met = [value for value in values if has_effect(tunable, gene, value)]
            assert missing is (len(met) < 2), gene
        else:
            assert missing is not hasattr(own, gene), gene


@pytest.mark.parametrize("name", space_names())
def test_a_spec_says_all_of_a_genotype(tunable, name):
    space = space_on(tunable, name)
    random = np.random.default_rng(5)
    sizes = [len(gene.values) for gene in space.genes]
    for genotype in [space.start, *(tuple(random.integers(sizes)) for _ in range(20))]:
        if name == "table3" and np.prod([space.values(genotype)[k] for k in TIMES]) < 1:
            continue  # less than one substep: refused, see below
        method = make_method(space.spec(genotype))
        assert method.parameters == space.parameters(genotype)
        plain = as_plain(method.parameters)
        for key, value in {**space.fixed, **space.values(genotype)}.items():
            assert plain[key] == value
        assert space.with_values(space.start, space.values(genotype)) == genotype
        assert space.genotype(space.spec(genotype)) == genotype


@pytest.mark.parametrize(
    ("spec", "message"),
    [
        ("sme", "sme: is no simulation on engine 'mujoco'"),
        ("label@bullet", "label@bullet: is no simulation on engine 'mujoco'"),
        (
            "ps_opt@mujoco:eps_t=10.2",
            "eps_t is 10.2; allowed in space 'extended': 6.0, 6.5, 7.0",
        ),
        ("label@mujoco:scope=all", "scope is 'all'; allowed in space 'extended': 'widening'"),
    ],
)
def test_what_a_space_does_not_hold_is_named(spec, message):
    with pytest.raises(TuningError) as caught:
        space_on("mujoco").genotype(spec)
    assert message in str(caught.value)


TIMES = ("t_max", "frequency")


def test_table_3_is_as_printed():
    """On Bullet, which honours all of it."""
    space = space_on("bullet", "table3")
    genes = {gene.name: gene for gene in space.genes}
    assert genes.keys() == FOUND.keys()
    assert space.values(space.start) == FOUND
    for name, (least, most, step) in PRINTED.items():
        values = genes[name].values
        assert values[0] == least
        assert most - step < values[-1] <= most, name
        np.testing.assert_allclose(np.diff(values), step)
        for value in values:  # nothing like 0.30000000000000004 in a spec
            assert len(f"{value!r}") <= 5, (name, value)
    assert set(genes["broad_phase"].values) == {"simple", "dbvt"}
    sizes = [len(genes[name].values) for name in ("eps_t", "t_max", "frequency", "linear_damping")]
    assert sizes == [100, 30, 20, 4]
    assert genes["t_max"].text == "0.1 to 3, step 0.1"


def test_the_start_of_the_default_space_asks_the_question_of_the_labels(tunable):
    """``label`` at 90 Hz, simulated no further than it must."""
    space = space_on(tunable)
    start = as_plain(space.parameters(space.start))
    label = as_plain(make_method(f"label@{tunable}").parameters)
    speed = {"frequency", "broad_phase", "solver_iterations", "samples", "rest_speed", "scope"}
    assert {key for key in label if start[key] != label[key]} <= speed


def test_less_than_a_substep_is_no_genotype():
    space = space_on("bullet", "table3")
    genotype = space.with_values(space.start, {"t_max": 0.1, "frequency": 5})
    with pytest.raises(ValueError, match=r"0\.5 substeps a placement"):
        space.spec(genotype)


@pytest.mark.parametrize(
    ("engine", "name", "message"),
    [
        ("bulet", "table3", "unknown engine 'bulet'; did you mean 'bullet'?"),
        ("bullet", "table4", "unknown space 'table4'; did you mean 'table3'?"),
        ("bullet", "groups", "unknown space 'groups'"),
        ("reference", "extended", "'reference' chooses its own steps: there is nothing to tune"),
    ],
)
def test_what_cannot_be_searched_is_refused(engine, name, message):
    with pytest.raises(TuningError) as caught:
        space_on(engine, name)
    assert message in str(caught.value)


def test_contacts_are_searched_on_an_engine_that_chooses_its_own_steps():
    space = space_on("reference", "motion")
    assert [gene.name for gene in space.genes] == ["friction", "stiffness", "damping_time"]
    parameters = space.parameters(space.with_values(space.start, {"damping_time": 6e-5}))
    assert parameters.damping_time == 6e-5
    usual = make_method("label@reference").parameters.world_settings().options
    start = space.parameters(space.start).world_settings().options
    assert all(start.value(name) == usual.value(name) for name in ("stiffness", "damping_time"))


# --- made from a tuned parameter set ------------------------------------------------------------


def far_from_start(engine):
    """A parameter set with every gene as far from the start as it goes."""
    space = space_on(engine)
    ends = [(0, len(gene.values) - 1) for gene in space.genes]
    genotype = tuple(
        max(pair, key=lambda at: abs(at - begin))
        for pair, begin in zip(ends, space.start, strict=True)
    )
    return space, genotype, as_plain(space.parameters(genotype))


def changed(spec, tuned):
    values = as_plain(make_method(spec).parameters)
    return {key for key in values if values[key] != tuned[key]}


def test_a_change_touches_the_genes_of_its_group_alone(tunable):
    space, _, tuned = far_from_start(tunable)
    searched, start = {gene.name for gene in space.genes}, space.values(space.start)
    changes = without_gains(space, tuned)
    groups = {name: searched & set(genes) for name, genes in gene_groups().items()}
    expected = {name: genes for name, genes in groups.items() if genes}
    assert [change.name for change in changes] == [*expected, "everything"]
    for change in changes:
        assert changed(change.spec, tuned) == expected.get(change.name, searched)
        put_back = as_plain(make_method(change.spec).parameters)
        assert all(put_back[key] == start[key] for key in changed(change.spec, tuned))


def test_every_gene_is_in_one_group():
    grouped = [gene for genes in gene_groups().values() for gene in genes]
    assert len(grouped) == len(set(grouped))
    for engine in TUNABLE:
        for name in space_names():
            assert {gene.name for gene in space_on(engine, name).genes} <= set(grouped)


def test_what_is_as_at_the_start_is_no_change(tunable):
    space, _, tuned = far_from_start(tunable)
    start = space.values(space.start)
    nearly = {**as_plain(space.parameters(space.start)), "eps_t": tuned["eps_t"]}
    assert [c.name for c in without_gains(space, nearly)] == ["thresholds", "everything"]
    (change, everything) = without_gains(space, nearly)
    assert change.spec == everything.spec
    assert change.to == f"eps_t {start['eps_t']}"


def test_physical_values_are_those_of_the_label(tunable):
    _, _, tuned = far_from_start(tunable)
    label = as_plain(make_method("label@reference").parameters)
    changes = physical(tunable, tuned)
    assert changes[-1].name == "all of these"
    for change in changes:
        names = changed(change.spec, tuned)
        assert names, "a change without effect"
        values = as_plain(make_method(change.spec).parameters)
        assert all(values[name] == label[name] for name in names)


@pytest.mark.parametrize("there", TUNABLE)
def test_carried_over_names_what_has_no_effect_there(tunable, there):
    _, _, tuned = far_from_start(tunable)
    spec, lost = carried_over(tuned, there)
    values = as_plain(make_method(spec).parameters)
    asked = {key: value for key, value in tuned.items() if value is not None}
    shared = {field.name for field in dataclasses.fields(SimulationParameters)}
    for name, value in asked.items():
        if name not in values:
            assert name not in shared
            assert name in lost
        else:
            assert values[name] == value
            neutral = getattr(WorldSettings(friction=0.0), name, value)
            dead = name in SETTINGS and value != neutral and not has_effect(there, name, value)
            assert (name in lost) is dead, name
    if there == tunable:
        assert not lost
