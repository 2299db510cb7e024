"""Single views without a server: answers that come late or fail, double clicks, and names that change."""

from __future__ import annotations

from collections.abc import Iterator

import pytest

pytest.importorskip("playwright.sync_api")

from playwright.sync_api import Browser, Page

from tests.e2e.single_view import empty_page, result


@pytest.fixture
def page(browser: Browser) -> Iterator[Page]:
    with empty_page(browser) as page:
        yield page


def test_a_double_click_shows_earlier_work_once(page: Page) -> None:
    team = """
    const { createTeam } = await load('team.js');
    const video = { video_id: 'v', run_id: 'r', video_name: '' };
    const done = { ...video, time: '', name: 'set_review', count: 2, tracks: [], frame: 0 };
    const activity = async (name, cursor) => ({ worker: worker(name), done: [done], more: cursor === null ? 5 : null });
    const view = createTeam(stub({ session }, { activity }));
    view.update({ route: { screen: 'team', person: 'Anna' }, session });
    await settle();
    for (const _ of [1, 2]) buttonOf(view.element, 'Show earlier').click();
    await settle();
    return view.element.querySelectorAll('.activity li').length;"""
    assert result(page, team) == 2
    history = """
    const { createHistory } = await load('inspector/history.js');
    const trackHistory = async (run, key, cursor) => ({ happened: [change], more: cursor === null ? 5 : null });
    const view = createHistory(stub({ labels: [] }, { trackHistory }), signal);
    document.body.append(view.element);
    view.element.open = true;
    view.update(inspected('m1'));
    await settle();
    for (const _ of [1, 2]) buttonOf(view.element, 'Show earlier').click();
    await settle();
    view.element.remove();
    return view.element.querySelectorAll('li').length;"""
    assert result(page, history) == 2


def test_a_notice_below_a_dialog_stays_until_the_dialog_is_closed(page: Page) -> None:
    body = """
    const { createToasts } = await load('toasts.js');
    const { toast } = await import('/static/js/core/toast.js');
    const timers = new Map();
    globalThis.setTimeout = (run) => timers.set(timers.size + 1, run).size;
    globalThis.clearTimeout = (id) => timers.delete(id);
    const state = { dialog: { kind: 'help' }, review: null };
    const toasts = createToasts(stub(state, {}));
    toasts.update(state);
    toast('The bundle is ready.', { stays: true });
    const below = timers.size;
    state.dialog = null;
    toasts.update(state);
    const after = timers.size;
    for (const run of timers.values()) run();
    return [below, after, toasts.element.childElementCount];"""
    assert result(page, body) == [0, 1, 0]


def test_values_that_are_loading_are_not_said_to_be_missing(page: Page) -> None:
    """What frame and events of the inspector say before the engine's values are there, and without any."""
    body = """
    const { createExplain } = await load('inspector/explain.js');
    const { createEvents } = await load('inspector/events.js');
    const sections = [createExplain(stub({}, {}), signal), createEvents(stub({}, {}))];
    const track = { ...inspected('m1'), doc: null, lane: null, laneData: null, sentences: [] };
    track.review.frame = 0;
    return [false, true].map((isLoaded) => {
      for (const section of sections) section.update({ ...track, isLoaded });
      return sections.map(({ element }) => element.textContent);
    });"""
    loading, loaded = result(page, body)
    assert ["loading…" in text for text in loading] == [True, True]
    assert loaded[0].endswith("The track has no box of the engine in this frame.")
    assert loaded[1].startswith("Events0")


def test_a_double_click_gives_one_second_opinion(page: Page) -> None:
    body = """
    const { createSecondOpinionForm } = await load('second_opinion.js');
    const look = { id: 'l', box: [0, 0, 9, 9], labels: [], video_name: '', frame: 0, run_id: 'r' };
    const answered = [];
    const form = createSecondOpinionForm(stub({}, {
      nextSecondOpinion: async () => ({ look, left: 2 }),
      answerSecondOpinion: async (id) => answered.push(id),
      searchCropUrl: () => null,
    }), signal);
    await settle();
    const button = buttonOf(form, 'No sign');
    for (const _ of [1, 2]) button.click();
    await settle();
    return answered.length;"""
    assert result(page, body) == 1


def test_a_late_answer_about_another_person_is_not_shown(page: Page) -> None:
    body = """
    const { createTeam } = await load('team.js');
    const requests = { Anna: later(), Bert: later() };
    const view = createTeam(stub({ session }, { activity: (name) => requests[name].promise }));
    for (const person of ['Anna', 'Bert']) view.update({ route: { screen: 'team', person }, session });
    for (const name of ['Bert', 'Anna']) {
      requests[name].resolve({ worker: worker(name), done: [], more: null });
      await settle();
    }
    return view.element.querySelector('h1').textContent;"""
    assert result(page, body) == "Bert"


def test_the_history_of_another_track_does_not_stay(page: Page) -> None:
    body = """
    const { createHistory } = await load('inspector/history.js');
    const trackHistory = async (run, key) => {
      if (key === 'm2') throw new Error('unreachable');
      return { happened: [change], more: null };
    };
    const view = createHistory(stub({ labels: [] }, { trackHistory }), signal);
    document.body.append(view.element);
    view.element.open = true;
    const shown = [];
    for (const key of ['m1', 'm2']) {
      view.update(inspected(key));
      await settle();
      shown.push(view.element.querySelectorAll('li').length);
    }
    view.element.remove();
    return shown;"""
    assert result(page, body) == [1, 0]


def test_a_history_that_was_left_while_it_loaded_is_loaded_again(page: Page) -> None:
    body = """
    const { createHistory } = await load('inspector/history.js');
    const answers = [];
    const trackHistory = () => {
      answers.push(later());
      return answers.at(-1).promise;
    };
    const view = createHistory(stub({ labels: [] }, { trackHistory }), signal);
    document.body.append(view.element);
    for (const [key, open] of [['m1', true], ['m2', false], ['m1', true]]) {
      view.element.open = open;
      view.update(inspected(key));
      await settle();
      if (key === 'm2') answers[0].resolve({ happened: [change], more: null });
      await settle();
    }
    answers.at(-1).resolve({ happened: [change], more: null });
    await settle();
    view.element.remove();
    return view.element.querySelectorAll('li').length;"""
    assert result(page, body) == 1


def test_a_view_beside_the_picture_that_is_opened_again_exists_once(page: Page) -> None:
    body = """
    const { createViewerPanel } = await load('viewer_panel.js');
    const signals = [];
    const add = window.addEventListener;
    window.addEventListener = (type, listener, options) => {
      if (type === 'tsr:scene3d') signals.push(options.signal);
      add.call(window, type, listener, options);
    };
    const panel = createViewerPanel(stub({ review: null }, { base: '/api' }), () => {});
    for (const beside of ['scene3d', null, 'scene3d']) panel.update({ review: { beside } });
    while (signals.length < 2) await settle();
    window.addEventListener = add;
    return [signals.length, signals.filter(({ aborted }) => !aborted).length];"""
    assert result(page, body) == [2, 1]


def test_the_offer_to_record_names_the_frames_that_it_records(page: Page) -> None:
    body = """
    const { createRecordingView } = await load('recording/index.js');
    const { fetch } = globalThis;
    globalThis.fetch = async () => new Response('{"outputs": []}', { headers: { 'Content-Type': 'application/json' } });
    const view = createRecordingView(stub({}, { base: '/api' }));
    globalThis.fetch = fetch;
    const shown = [];
    for (const [id, frame] of [['a', 500], ['a', 10], ['b', 500], ['b', 10]]) {
      view.update({ outputs: null, review: { frame, selected: null, run: { id, first: 0, frames_done: 1000 } } });
      await settle();
      shown.push(view.element.querySelector('.empty-actions').textContent);
    }
    return shown;"""
    assert result(page, body) == ["Record frames 350 to 649", "Record frames 0 to 299"] * 2


def test_a_list_without_files_names_the_chosen_kind(page: Page) -> None:
    body = """
    const { createFiles } = await load('files.js');
    const state = { outputs: [], videos: [], runs: {} };
    const view = createFiles(stub(state, { outputs: async () => [] }));
    view.update(state);
    const kinds = view.element.querySelector('select');
    return ['export', 'recording', ''].map((kind) => {
      kinds.value = kind;
      kinds.dispatchEvent(new Event('change'));
      return view.element.querySelector('h2').textContent;
    });"""
    assert result(page, body) == ["No exports yet", "No recordings yet", "No files yet"]


def test_a_comparison_uses_the_labels_of_its_video(page: Page) -> None:
    body = """
    const { createCompare } = await load('compare.js');
    const label = (name) => ({ id: 3, key: name, name, picture: null, merged_into: null, hidden: false });
    const places = { frames: [0], lasts: [0], tracks: ['m1'], partners: [null], pairs: [] };
    const cell = { reference: 3, candidate: 3, count: 1, ...places };
    const side = (name) => ({ name, kind: 'run', tracks: 1, boxes: 1, names: {}, edited: false });
    const compare = async (reference, candidate) => ({
      reference, candidate, video_id: 'v', first: 0, last: 9, figures: {},
      sides: { reference: side('a'), candidate: side('b') },
      confusion: { classes: [3], cells: [cell], words: {} },
    });
    const labels = async (video) => [label(video === 'v' ? 'moose' : 'other')];
    const route = { screen: 'compare', a: 'run:a', b: 'run:b' };
    const state = { labels: [label('kangaroo')], runs: { v: [] }, models: null, videos: [], route };
    const view = createCompare(stub(state, { compare, labels }));
    view.update(state);
    await settle();
    return view.element.querySelector('.matrix-head').textContent;"""
    assert result(page, body) == "moose"


def test_another_label_set_can_be_chosen_for_the_library(page: Page) -> None:
    body = """
    const { createLabels } = await load('labels/index.js');
    const labelSets = ['own', 'other'].map((key) => ({ key, name: key, version: 1, default: key === 'own' }));
    const labelUsage = async () => ({ labels: {}, unread: 0 });
    const view = createLabels(stub({}, { labelsOfSet: async () => [], labelUsage }));
    view.update({ labelSets });
    await settle();
    const sets = view.element.querySelector('select');
    return ['own', 'other', 'own'].map((key) => {
      sets.value = key;
      sets.dispatchEvent(new Event('change'));
      return buttonOf(view.element, 'Use for the library').hidden;
    });"""
    assert result(page, body) == [True, False, True]


def test_an_invalid_number_keeps_the_focus_only_after_enter(page: Page) -> None:
    body = """
    const { createAttributes } = await load('inspector/attributes.js');
    const { leaveField } = await load('lanes/gestures.js');
    const { blankDoc } = await import('/static/js/model/documents.js');
    const height = { name: 'height', kind: 'number', mutable: false, values: [], low: null, high: 9, default: null };
    const review = { frame: 0, selected: 'h1', docs: { h1: { ...blankDoc('h1'), class_id: 1 } }, run: null };
    const state = { review, labels: [{ id: 1, attributes: [height] }] };
    globalThis.told = [];
    globalThis.leaveField = leaveField;
    document.addEventListener('tsr-toast', ({ detail }) => told.push(detail.text));
    const view = createAttributes(stub(state, {}));
    document.body.append(view.element);
    view.update({ state, entry: { key: 'h1' } });"""
    result(page, body)
    page.locator("input").press_sequentially("12")
    page.keyboard.press("Enter")
    focused = "document.activeElement === document.querySelector('input')"
    assert page.evaluate(f"[{focused}, ...told]") == [True]
    page.keyboard.type("3")
    assert page.evaluate(f"leaveField(), [{focused}, ...told]") == [False, "height must be at most 9."]


@pytest.mark.parametrize("part", ["plot", "end"])
def test_a_press_on_the_lanes_leaves_a_text_field_first(page: Page, part: str) -> None:
    body = """
    const { attachGestures } = await load('lanes/gestures.js');
    const { createEndHandle } = await load('lanes/end_handle.js');
    const place = 'position: fixed; top: 200px; width: 100px; height: 50px; left: ';
    const plot = Object.assign(document.createElement('div'), { id: 'plot', style: `${place} 0` });
    const ends = Object.assign(document.createElement('div'), { id: 'end', style: `${place} 200px` });
    const input = document.createElement('input');
    globalThis.happened = [];
    input.addEventListener('change', () => happened.push(input.value));
    attachGestures(plot, 'seek', { press: () => happened.push('press'), seek: () => {} });
    const end = createEndHandle({ showFrame: () => happened.push('press'), endTrack: () => {} }, signal);
    end.update({ key: 'm1', first: 0, last: 9, x: 0, y: 0, height: 50, scale: 1 });
    ends.append(end.element);
    document.body.append(input, plot, ends);"""
    result(page, body)
    page.locator("input").press_sequentially("wet")
    page.locator(f"#{part}").click()
    page.keyboard.type("a")
    assert page.evaluate("[...happened, document.querySelector('input').value]") == ["wet", "press", "wet"]


def test_a_file_leads_to_its_run_once_that_is_known(page: Page) -> None:
    body = """
    const { createFiles } = await load('files.js');
    const file = { id: 'o', kind: 'recording', state: 'complete', name: 'a.rrd', run_id: 'r', options: { frame: 7 } };
    const requests = { videos: later(), runs: later() };
    const api = {
      outputs: async () => [{ ...file, summary: { videos: [{ name: 'drive' }] } }],
      videos: () => requests.videos.promise,
      runs: () => requests.runs.promise,
      downloadUrl: () => '',
    };
    let state = { outputs: null, videos: null, runs: {} };
    const view = createFiles(stub(null, api, {
      store: { get: () => state },
      load: async (request, action) => {
        state = action(state, await request());
        view.update(state);
      },
    }));
    const shown = [];
    for (const [name, answer] of [['videos', [{ id: 'v', runs: 1 }]], ['runs', [{ id: 'r', video_id: 'v' }]]]) {
      await settle();
      shown.push(view.element.querySelector('.made-actions a').getAttribute('aria-label'));
      requests[name].resolve(answer);
    }
    await settle();
    return [...shown, view.element.querySelector('.made-actions a').getAttribute('href')];"""
    assert result(page, body) == ["Download a.rrd"] * 2 + ["#/review/v/r?frame=7"]
