// @ts-check
/** Choose the two sides of a comparison. */

import { errorMessage } from '../../api/errors.js';
import { formatRoute } from '../../model/route.js';
import { listRuns } from '../../model/run_groups.js';
import { openDialog } from '../../store/actions/page.js';
import { fill, h, setText } from '../dom.js';
import { plural } from '../../model/format.js';
import { modelVersionSuffix } from '../model_version_text.js';
import { runTitle } from '../../model/describe_run.js';
import { loadRuns } from '../load_runs.js';

/**
 * The initial choice: the present comparison, else a run against ground truth or against its own corrections.
 *
 * @param {readonly string[]} offered   sides of the video that can be compared
 * @param {{run?: string|null, reference?: string, candidate?: string}} present   the open run, and the present comparison
 * @returns {{reference: string, candidate: string}|null} null: no run
 */
export function initialSides(offered, { run, reference, candidate }) {
  if (reference && candidate && offered.includes(reference) && offered.includes(candidate)) return { reference, candidate };
  const defaultRun = offered.find((side) => side === `run:${run}`) ?? offered.find((side) => side.startsWith('run:'));
  if (!defaultRun) return null;
  return {
    reference: offered.find((side) => side.startsWith('truth:')) ?? defaultRun.replace('run:', 'annotation:'),
    candidate: defaultRun,
  };
}

/**
 * The sides of a comparison after an import: ground truth is the reference, anything else the candidate.
 *
 * @param {{reference: string, candidate: string}} sides
 * @param {Pick<import('../../types.js').ImportResult, 'kind'|'id'>|null} found   null: nothing was imported
 */
export function sidesAfterImport(sides, found) {
  if (found === null) return sides;
  return { ...sides, [found.kind === 'truth' ? 'reference' : 'candidate']: `${found.kind}:${found.id}` };
}

/** @type {import('./index.js').CreateDialog<'compare'>} */
export function compareDialog({ app, data, close, signal }) {
  const { store, api } = app;
  let video = String(data.video);
  const usableVideos = (store.get().videos ?? []).filter(({ id, latest_run }) => latest_run !== null || id === video);
  const videos = h(
    'select.select',
    {
      id: 'compare-video',
      onchange: () => {
        video = videos.value;
        for (const select of [reference, candidate]) select.replaceChildren();
        delete candidate.dataset.chosen;
        check(); // nothing can be compared until its runs are loaded
        void load();
      },
    },
    ...usableVideos.map(({ id, name }) => h('option', { value: id, selected: id === video }, name)),
  );
  const reference = h('select.select', { id: 'compare-a', onchange: check });
  const candidate = h('select.select', { id: 'compare-b', onchange: check });
  const errorText = h('p.field-error', { role: 'alert' });
  const submitButton = h('button.btn.btn-primary', { type: 'submit', disabled: true }, 'Compare');
  /** @type {import('../../api/ground_truths.js').GroundTruth[]} */ let groundTruths = [];

  async function load() {
    try {
      const requestedVideo = video;
      const [runs, videoTruths] = await Promise.all([
        loadRuns(app, requestedVideo, { signal }),
        api.groundTruths(requestedVideo, { signal }),
      ]);
      if (requestedVideo !== video) return; // another video has been chosen meanwhile
      groundTruths = videoTruths;
      const listed = listRuns(runs.filter(({ state }) => state === 'complete'));
      const completeRuns = listed.map(({ run }) => run);
      const name = usableVideos.find(({ id }) => id === video)?.name ?? 'this video';
      const versions = store.get().models;
      /** @param {import('../../types.js').Run} run */
      const titleOf = (run) => `${runTitle(run)}${modelVersionSuffix(run, versions)}`;
      for (const select of [reference, candidate]) {
        const previousValue = select.value;
        fill(
          select,
          completeRuns.length > 0 &&
            h(
              'optgroup',
              { label: `Runs of ${name}` },
              ...listed.map(({ run, isWhatIf: under }) => h('option', { value: `run:${run.id}` }, `${under ? '↳ ' : ''}${titleOf(run)}`)),
            ),
          completeRuns.length > 0 &&
            h(
              'optgroup',
              { label: `Corrections on ${name}` },
              ...completeRuns
                .filter(({ kind }) => kind !== 'whatif')
                .map((run) => h('option', { value: `annotation:${run.id}` }, `Corrections of ${titleOf(run)}`)),
            ),
          groundTruths.length > 0 &&
            h(
              'optgroup',
              { label: `Ground truth of ${name}` },
              ...groundTruths.map((truth) =>
                h('option', { value: `truth:${truth.id}` }, `${truth.name}, ${plural(truth.count, 'box', 'boxes')}`),
              ),
            ),
        );
        if (previousValue) select.value = previousValue;
      }
      const initial = initialSides(
        [...reference.options].map(({ value }) => value),
        data,
      );
      if (initial && !candidate.dataset.chosen) {
        reference.value = initial.reference;
        candidate.value = initial.candidate;
        candidate.dataset.chosen = 'yes';
      }
      check();
      if (completeRuns.length === 0) setText(errorText, 'There is no complete run to compare yet. Wait until one is complete.');
    } catch (thrown) {
      if (!signal.aborted) setText(errorText, errorMessage(thrown));
    }
  }

  function check() {
    const isSame = reference.value === candidate.value;
    submitButton.disabled = !reference.value || !candidate.value || isSame;
    setText(errorText, isSame && reference.value ? 'Choose two different sides.' : '');
  }

  /** Import a file for the video, and come back with its result on one of the sides. */
  function importTruth() {
    const sides = { reference: reference.value, candidate: candidate.value };
    store.dispatch(openDialog, {
      kind: 'import',
      data: {
        video,
        as: 'truth',
        back: (found) => store.dispatch(openDialog, { kind: 'compare', data: { video, run: data.run, ...sidesAfterImport(sides, found) } }),
      },
    });
  }

  void load();
  return {
    title: 'Compare',
    size: 'narrow',
    focus: reference,
    submit: () => {
      if (submitButton.disabled) return;
      close();
      location.hash = formatRoute({ screen: 'compare', a: reference.value, b: candidate.value });
    },
    body: h(
      'div.stack',
      h('div.field', { hidden: usableVideos.length < 2 }, h('label.field-label', { for: 'compare-video' }, 'Video'), videos),
      h('div.field', h('label.field-label', { for: 'compare-a' }, 'Reference: taken as correct'), reference),
      h('div.field', h('label.field-label', { for: 'compare-b' }, 'Candidate: measured against the reference'), candidate),
      h('div', h('button.btn.btn-small', { onclick: importTruth }, 'Import ground truth …')),
      errorText,
    ),
    footer: [h('span.grow'), h('button.btn', { onclick: close }, 'Cancel'), submitButton],
  };
}
