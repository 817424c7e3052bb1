"""Spec strings parse, print back, and complain with the nearest name."""

import pytest

from steadyload.methods import make_method
from steadyload.methods.contract.spec import SpecError, parse_spec
from steadyload.methods.registry import method_listing, presets


@pytest.mark.parametrize(
    ("text", "canonical"),
    [
        ("fbs", "fbs"),
        (" pbs:alpha=0.70 ", "pbs:alpha=0.7"),
        ("ps3@bullet", "ps3@bullet"),
        ("ps3@mujoco:samples=1,t_max=0.2", "ps3@mujoco:t_max=0.2,samples=1"),
        ("simulation@dart:t_max=300ms,eps_t=0.22m", "simulation@dart:t_max=0.3,eps_t=22"),
        ("simulation@dart:margin=0.4mm", "simulation@dart:margin=0.0004"),
        ("simulation@dart:frequency=1kHz,eps_r=7deg", "simulation@dart:frequency=1000,eps_r=7"),
        ("simulation@mujoco:emulate=restitution", "simulation@mujoco:emulate=restitution"),
        ("ps3@bullet:broad_phase=none", "ps3@bullet:broad_phase=none"),
    ],
)
def test_a_spec_prints_back_in_canonical_form(text, canonical):
    spec = make_method(text).spec
    assert str(spec) == canonical
    assert str(make_method(canonical).spec) == canonical
    assert make_method(canonical).parameters == make_method(text).parameters


def test_every_parameter_of_table_3_is_there_with_its_value():
    p = make_method("ps_opt-paper@bullet").parameters
    assert (p.eps_t, p.eps_r, p.t_max, p.frequency) == (22, 7, 0.3, 90)  # cm, degrees, s, Hz
    assert (p.restitution, p.friction, p.linear_damping, p.angular_damping) == (
        0.11,
        0.5,
        0.06,
        0.01,
    )
    assert (p.margin, p.broad_phase) == (0.006, "dbvt")


def test_presets_can_be_overridden():
    base = make_method("ps3@bullet").parameters
    carried = make_method("ps3@bullet:between_steps=carry").parameters
    assert (base.between_steps, carried.between_steps) == ("reseat", "carry")
    assert base.t_max == carried.t_max == 0.4


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("", "is not of the form"),
        ("fbs:", ""),
        ("sm", "unknown method 'sm'; did you mean 'sme'?"),
        ("ps3", "needs an engine"),
        ("sme@bullet", "needs no engine"),
        ("ps3@bulet", "unknown engine 'bulet'; did you mean 'bullet'?"),
        ("pbs:alfa=0.5", "unknown parameter 'alfa'; did you mean 'alpha'?"),
        ("pbs:alpha=1.5", "alpha is 1.5; allowed: a number, 0 to 1"),
        ("pbs:alpha=nan", "allowed: a finite number"),
        ("pbs:alpha=half", "alpha is 'half'"),
        ("pbs:alpha=", "is not of the form key=value"),
        ("pbs:alpha=0.5,alpha=0.6", "alpha stands there twice"),
        ("fbs:alpha=1", "unknown parameter 'alpha'"),
        ("ps3@bullet:frequency=0", "frequency is 0; allowed: a number, 1 to"),
        ("ps3@mujoco:t_max=1e-6", "is 0.0006 substeps a placement; allowed: 1 or more"),
        ("pbs:alpha=\uff11", "a finite number"),
        ("simulation@bullet:early_exit=2", "early_exit needs criterion=adams"),
        ("simulation@bullet:criterion=adams,early_exit=0.5", "allowed: 0, or 1 or more"),
        ("ps3@bullet:t_max=3cm", "allowed units: s, ms"),
        ("ps3@bullet:samples=1.5", "a whole number"),
        ("label@reference:jitter=0.001", "jitter is 0.001; allowed: a number, 0 to 0.0001 [m]"),
        ("label@mujoco:jitter=0.11mm", "jitter is 0.00011; allowed: a number, 0 to 0.0001 [m]"),
        ("ps3@bullet:criterion=papr", "did you mean 'paper'?"),
        ("ps3@bullet:broad_phase=octree", "simple"),
        ("ps3@mujoco:emulate=restution", "did you mean 'restitution'?"),
    ],
)
def test_a_wrong_spec_says_what_is_allowed(text, message):
    if not message:
        assert str(make_method(text).spec) == "fbs"
        return
    with pytest.raises(SpecError) as caught:
        make_method(text)
    assert message in str(caught.value)


def test_parsing_knows_nothing_of_methods():
    assert str(parse_spec("anything@anywhere:a=1")) == "anything@anywhere:a=1"


def test_a_parameter_is_stated_in_another_way():
    stated = parse_spec("lstm_1@anywhere:outside=refuse,batch=2").stating("batch", 8)
    assert str(stated) == "lstm_1@anywhere:outside=refuse,batch=8"
    assert str(parse_spec("lstm_1").stating("outside", "accept")) == "lstm_1:outside=accept"


def test_the_listing_explains_every_parameter():
    listing = {m.name: m for m in method_listing()}
    assert set(presets()) < set(listing)
    for method in listing.values():
        assert method.about
        assert all(p.about and p.allowed for p in method.parameters)
    table = {p.name: p for p in listing["ps_opt-paper"].parameters}
    assert (table["eps_t"].value, table["eps_t"].unit) == ("22", "cm")


def test_options_of_an_engine_are_parameters_on_that_engine_alone():
    method = make_method("simulation@reference:stiffness=1e8,tolerance=1e-6,t_max=0.2")
    assert str(method.spec) == "simulation@reference:t_max=0.2,tolerance=1e-06,stiffness=100000000"
    assert make_method(str(method.spec)).parameters == method.parameters
    options = method.parameters.world_settings().options
    assert (options.tolerance, options.stiffness, options.contact) == (1e-6, 1e8, "stiff")
    assert options.law(0.5).stiffness == 1e8
    assert options.law(0.5).damping == 3e5
    assert make_method("simulation@bullet").parameters.world_settings().options is None
    for spec, message in (
        ("simulation@mujoco:stiffness=1e8", "unknown parameter 'stiffness'"),
        ("simulation@mujoco:impedance=1", "impedance is 1; allowed: a number, 0.0001 to 0.9999"),
        ("simulation@dart:impedance=0.9", "unknown parameter 'impedance'"),
        ("label@reference:contact=stif", "did you mean 'stiff'"),
        (
            "label@reference:tolerance=1",
            r"tolerance is 1; allowed: a number, 1e-12 to 0.0001 \[m\]",
        ),
        ("label@reference:stiction_speed=0.5", "friction_speed is 0.01 m/s; allowed: more than"),
    ):
        with pytest.raises(SpecError, match=message):
            make_method(spec)


def test_the_jitters_of_kept_labels_stay_allowed():
    for jitter in ("1e-6", "1e-5", "0.01mm", "1e-4", "0.1mm"):
        assert make_method(f"label@reference:jitter={jitter}").parameters.jitter <= 1e-4


def test_the_label_is_the_way_the_published_labels_were_made():
    p = make_method("label@reference").parameters
    assert (p.t_max, p.eps_t, p.eps_r, p.friction, p.gravity) == (0.3, 10, 10, 0.5, 9.8)
    assert (p.between_steps, p.criterion, p.samples) == ("reseat", "adams", 10)


def test_the_contact_of_the_paper_is_converted_from_centimetres():
    law = make_method("label@reference:contact=adams").parameters.world_settings().options.law(0.5)
    # 6e7 N at a depth of 1 cm, 800 N at 1 cm/s; full at 0.001 cm; 0.375 of 0.5; 0.01 and 1 cm/s.
    assert law.stiffness * 0.01**law.exponent == pytest.approx(6e7)
    assert law.damping * 0.01 == pytest.approx(800.0)
    assert law.damping_depth == pytest.approx(1e-5)
    assert law.dynamic_friction == pytest.approx(0.375)
    assert (law.stiction_speed, law.friction_speed) == (1e-4, 1e-2)
