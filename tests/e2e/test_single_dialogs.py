"""Single dialogs without a server: answers that come late, and what is started twice."""

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


def test_a_refusal_after_the_end_of_its_dialog_is_shown(page: Page) -> None:
    body = """
    const { confirmDialog } = await load('dialogs/confirm.js');
    const [end, request, told] = [new AbortController(), later(), []];
    document.addEventListener('tsr-toast', ({ detail }) => told.push(detail), { once: true });
    const data = { title: '', text: '', confirm: 'Remove', run: () => request.promise };
    const { footer } = confirmDialog({ data, close: () => {}, signal: end.signal });
    footer[1].click();
    end.abort();
    const { ApiError } = await import('/static/js/api/errors.js');
    request.reject(new ApiError(409, 'busy', 'A run is in progress.'));
    await settle();
    return told.map(({ text, tone }) => [text, tone]);"""
    assert result(page, body) == [["A run is in progress.", "bad"]]


def test_the_folder_that_was_opened_last_is_shown(page: Page) -> None:
    body = """
    const { addVideoDialog } = await load('dialogs/add_video.js');
    const requests = { null: later(), '/slow': later(), '/fast': later() };
    const app = stub({ session: { roots: ['/slow', '/fast'] } }, { browse: (path) => requests[path].promise });
    const { body } = addVideoDialog({ app, close: () => {}, signal });
    for (const name of ['slow', 'fast']) buttonOf(body, name).click();
    for (const path of ['/fast', '/slow', 'null']) {
      const videos = [{ name: `${path}.mp4`, path, size: 1 }];
      requests[path].resolve({ path, parent: null, folders: [], videos, truncated: false });
      await settle();
    }
    return body.querySelector('[data-path]').dataset.path;"""
    assert result(page, body) == "/fast"


def test_a_renamed_run_has_its_new_name_everywhere(page: Page) -> None:
    body = """
    const { createRunItem, updateRunItem } = await load('dialogs/run_item.js');
    const run = { id: 'r', video_id: 'v', name: 'old', kind: 'engine', state: 'complete', first: 0, stop: null };
    const renamed = { ...run, name: 'fresh', parameters: {}, models: {}, summary: {}, frames_done: 1 };
    const app = stub({ runs: { v: [renamed] }, route: { screen: 'library' }, review: null, models: null }, {});
    const item = createRunItem({ app, close: () => {}, signal }, run);
    updateRunItem({ app }, item, { run: renamed, isWhatIf: false, whatifs: 1 });
    for (const name of ['whatifs', 'remove']) item.querySelector(`.run-${name}`).click();
    const labels = ['rename', 'remove', 'new-name'].map((name) => item.querySelector(`.run-${name}`).ariaLabel);
    return [...labels, ...app.dispatched.map(({ data }) => data.text)].map((text) => /old|fresh/.exec(text)[0]);"""
    assert result(page, body) == ["fresh"] * 5


def test_another_run_opens_at_the_frame_on_the_screen(page: Page) -> None:
    body = """
    const { createRunItem } = await load('dialogs/run_item.js');
    const review = { video: { id: 'v' }, timebase: {}, frame: 7 };
    const app = stub({ runs: {}, route: { screen: 'review', video: 'v', frame: 3 }, review }, {});
    const found = [];
    const setup = { app, close: () => found.push('closed'), signal };
    const link = createRunItem(setup, { id: 'r', video_id: 'v' }).querySelector('a');
    link.addEventListener('click', (event) => event.preventDefault());
    found.push(link.hash);
    review.frame = 9;
    link.click();
    return [...found, link.hash];"""
    assert result(page, body) == ["#/review/v/r?frame=7", "closed", "#/review/v/r?frame=9"]


def test_deleting_a_ground_truth_leaves_the_shown_one(page: Page) -> None:
    body = """
    const { groundTruthsDialog } = await load('dialogs/ground_truths.js');
    const groundTruths = ['shown', 'other'].map((id) => ({ id, name: id, count: 1 }));
    const calls = [];
    const app = stub({ review: { video: { id: 'v' }, truthId: 'shown' } }, {
      groundTruths: async () => groundTruths,
      removeTruth: async () => {},
    }, { loader: { showTruth: (id) => calls.push(id) } });
    const { body } = groundTruthsDialog({ app, data: { video: 'v' }, close: () => {}, signal });
    await settle();
    for (const name of ['other', 'shown']) body.querySelector(`[aria-label="Delete ${name}"]`).click();
    for (const { data } of app.dispatched) {
      await data.run();
      calls.push(data.text.split(' ')[0]);
    }
    return calls;"""
    assert result(page, body) == ["other", None, "shown"]


def test_a_running_import_is_not_started_again(page: Page) -> None:
    body = """
    const { importDialog } = await load('dialogs/import.js');
    const { importBundleDialog } = await load('dialogs/import_bundle.js');
    const started = [];
    const start = (kind) => {
      started.push(kind);
      return later().promise;
    };
    const app = stub({ videos: [{ id: 'v', name: 'v' }], labels: [], session: null, review: null }, {
      formats: async () => [],
      labels: async () => [],
      runs: async () => [],
      importFile: () => start('file'),
      importBundle: () => start('bundle'),
    });
    const data = { video: 'v', as: 'truth', file: new File(['x'], 'signs.csv') };
    for (const create of [importDialog, importBundleDialog]) {
      const dialog = create({ app, data, close: () => {}, signal });
      await settle();
      const input = dialog.body.querySelector('input[type="file"]');
      const files = new DataTransfer();
      files.items.add(data.file);
      for (const _ of [1, 2]) {
        dialog.submit();
        input.files = files.files;
        input.dispatchEvent(new Event('change'));
      }
      started.push(dialog.footer.at(-1).disabled);
    }
    return started;"""
    assert result(page, body) == ["file", True, "bundle", True]


def test_a_dialog_that_is_closed_during_an_import_says_so(page: Page) -> None:
    body = """
    const { importDialog } = await load('dialogs/import.js');
    const { importBundleDialog } = await load('dialogs/import_bundle.js');
    const told = [];
    document.addEventListener('tsr-toast', ({ detail }) => told.push(detail.text));
    const ended = (signal) => new Promise((_, reject) => signal.addEventListener('abort', () => reject(signal.reason)));
    const app = stub({ videos: [{ id: 'v', name: 'v' }], labels: [], session: null, review: null }, {
      formats: async () => [],
      labels: async () => [],
      runs: async () => [],
      importFile: (video, file, options, { signal }) => ended(signal),
      importBundle: (file, author, { signal }) => ended(signal),
    });
    for (const [create, name] of [[importDialog, 'signs.csv'], [importBundleDialog, 'bug.zip']]) {
      const data = { video: 'v', as: 'truth', file: new File(['x'], name) };
      const lifetime = new AbortController();
      const dialog = create({ app, data, close: () => {}, signal: lifetime.signal });
      await settle();
      dialog.submit();
      await settle();
      lifetime.abort();
      await settle();
    }
    return told;"""
    sentences = result(page, body)
    assert [text.partition(", so it is cancelled")[0] for text in sentences] == [
        "The dialog was closed during the import of signs.csv",
        "The dialog was closed during the import of bug.zip",
    ]


def test_frames_that_cannot_be_assigned_are_refused_in_the_words_of_the_fields(page: Page) -> None:
    body = """
    const { assignDialog } = await load('dialogs/assign.js');
    const requests = [];
    const state = { videos: [{ id: 'v', name: 'drive.mp4', frames: 300 }], assignments: [] };
    const assign = async (request) => (requests.push(request), []);
    const app = stub(state, { people: async () => [worker('Anna')], assign });
    const dialog = assignDialog({ app, data: { video: 'v' }, close: () => {}, signal });
    const fields = dialog.body.querySelectorAll('input');
    const told = [];
    for (const [first, last] of [['250', '100'], ['0', '300'], ['', '9'], ['250', '299']]) {
      [fields[0].value, fields[1].value] = [first, last];
      await dialog.submit();
      await settle();
      told.push(dialog.body.querySelector('.field-error').textContent);
    }
    return [told.slice(0, 3), requests.map(({ first, stop }) => [first, stop])];"""
    assert result(page, body) == [
        [
            "The last frame comes before the first.",
            "The last frame must be a whole number from 0 to 299.",
            "The first frame must be a whole number from 0 to 299.",
        ],
        [[250, None]],
    ]


def test_the_history_of_a_label_set_says_what_was_shipped(page: Page) -> None:
    """Also after the first change, which stores the shipped version at its own time."""
    body = """
    const { labelHistoryDialog } = await load('dialogs/label_history.js');
    const created = '2026-11-29T11:39:00Z';
    const versions = [
      { version: 2, author: 'Anna', created, sentence: 'Added', undoes: null },
      { version: 1, author: '', created, sentence: 'Came with tsr.', undoes: null },
    ];
    const app = stub({}, { labelHistory: async () => versions });
    const { body } = labelHistoryDialog({ app, data: { set: 'gtsrb-43' }, close: () => {}, signal });
    await settle();
    return [...body.querySelectorAll('li .muted')].map(({ textContent }) => textContent);"""
    changed, shipped = result(page, body)
    assert changed.startswith("Version 2 · Anna · ")
    assert shipped == "Version 1, as shipped with tsr"
