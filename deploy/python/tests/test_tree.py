import pytest

import coppice
import environments
from coppice.tree import to_text


def test_a_tick_keeps_the_last_action_written_whether_or_not_its_branch_succeeds() -> None:
    tree = coppice.Tree.parse("(selector (sequence move s4=1 turn_right) s3=0)")
    assert tree({"s4": 1, "s3": 1}) == "turn_right"
    assert tree({"s4": 0, "s3": 1}) == "move"
    assert coppice.Tree.parse("(sequence s3=0 move)")({"s3": 1}) is None


def test_bins_and_numbers_are_compared_as_they_are_written() -> None:
    tree = coppice.Tree.parse("(selector (sequence angle<=0.0419 left) (sequence x=-0.25 wait) right)")
    assert tree({"angle": 0.0419, "x": 0.0}) == "left"
    assert tree({"angle": 0.042, "x": -0.25}) == "wait"
    assert tree({"angle": 0.042, "x": 1.0}) == "right"
    assert coppice.Tree.parse("(sequence angle<=inf left)")({"angle": 1e300}) == "left"


def test_text_is_read_back_as_it_was_written() -> None:
    for text in ("move", "s3=0", "(selector (sequence s3=0 turn_left) x<=-0.25 y<=1e-07 move)"):
        assert to_text(coppice.Tree.parse(text).root) == text
        assert coppice.Tree.parse("# note\n" + text + "\n").text == text


@pytest.mark.parametrize(
    "text, message",
    [
        ("", "holds 0 trees"),
        ("a\nb", "holds 2 trees"),
        ("(sequence a", "not complete"),
        ("(sequence)", "expected a node before"),
        ("a b", "expected the end"),
        ("(parallel a)", "expected sequence or selector"),
        ("x=one", "expected a number"),
        ("(sequence " * 70 + "a" + ")" * 70, "deeper than 64"),
        ('{"tree": {"type": "inverter"}}', "tree: found"),
        ('{"tree": {"type": "sequence", "children": [{"type": "condition", "op": "!="}]}}', r"children\[0\].op"),
        ('{"tree": ', "not JSON"),
    ],
)
def test_what_is_no_tree_is_refused_with_its_place(text: str, message: str) -> None:
    with pytest.raises(coppice.CoppiceError, match=message):
        coppice.Tree.parse(text)


def test_json_names_features_and_actions_so_that_arrays_and_numbers_will_do() -> None:
    tree = coppice.Tree.parse(
        '{"features": [{"name": "x"}, {"name": "y"}], "actions": [{"name": "go"}, {"name": "stop"}],'
        ' "tree": {"type": "selector", "children": [{"type": "sequence", "children": ['
        '{"type": "condition", "feature": "y", "op": "<=", "value": 0.5}, {"type": "action", "action": "stop"}]},'
        '{"type": "action", "action": "go"}]}}'
    )
    assert tree([3.0, 0.5]) == "stop"
    assert tree.index([3.0, 0.6]) == 0
    assert len(tree) == 5
    with pytest.raises(coppice.CoppiceError, match="3 numbers"):
        tree([1, 2, 3])
    with pytest.raises(coppice.CoppiceError, match="has no 'y'"):
        tree({"x": 1})


def test_what_an_environment_with_a_dict_space_gives_is_laid_flat() -> None:
    names = coppice.problem_of(environments.Mixed()).feature_names
    features = ", ".join(f'{{"name": "{name}"}}' for name in names)
    text = '"tree": {"type": "sequence", "children": [{"type": "condition", "feature": "%s", "op": "<=", "value": %s}, '
    text += '{"type": "action", "action": "go"}]}'
    observation = environments.Mixed().reset()[0]
    for feature, value, action in (("pose_1", -0.5, "go"), ("pose_0", 0.4, None), ("gear", 2, "go"), ("flags_1", -1, None)):
        tree = coppice.Tree.parse('{"features": [%s], "actions": [{"name": "go"}], %s}' % (features, text % (feature, value)))
        assert tree(observation) == action
    with pytest.raises(coppice.CoppiceError, match="has no 'flags_1'"):
        tree({"gear": 2, "pose": [0.5, -0.5, 0.0]})
