// @ts-check
/** Report a bug: pack everything that is needed to reproduce it into one file. */

import { sentence } from '../../api/errors.js';
import { shownSpan } from '../../model/effective.js';
import { listNames, trackName } from '../../model/track_name.js';
import { correctedKeys } from '../../review/shown_tracks.js';
import { putOutput } from '../../store/actions/page.js';
import { h, setText } from '../dom.js';
import { count, plural } from '../../model/format.js';
import { icon } from '../icons.js';
import { tellWhenMade } from '../made_notice.js';
import { toast } from '../../core/toast.js';
import { createFrameRange } from './frame-range.js';
import { field, tick } from './fields.js';

const OFFERED = 150;
const MOST = 3000;

/**
 * The expectation that the replay is compared with.
 *
 * @param {number} corrected   tracks that people accepted, rejected or corrected
 */
export function expectedWords(corrected) {
  if (!corrected) return 'No track is corrected yet. Correct what is wrong first: the replay is compared with your corrections.';
  return `The replay is compared with your corrections of ${plural(corrected, 'track')}, as far as these frames show ${corrected === 1 ? 'it' : 'them'}.`;
}

/** Maximum number of tracks that a sentence names. */
const NAMED = 4;

/**
 * A warning about tracks that end after the clip; empty: none.
 *
 * @param {readonly string[]} names
 * @param {number} last   last frame of the clip
 */
export function goingOnWords(names, last) {
  if (names.length === 0) return '';
  const named = listNames(names, NAMED);
  return `${names.length === 1 ? `Track ${named} continues` : `Tracks ${named} continue`} after frame ${count(last)}. Without all votes, a class is expected only if you set it. A later last frame includes ${names.length === 1 ? 'it' : 'them'} completely.`;
}

/**
 * @param {import('./layer.js').Setup<'bundle'>} setup
 * @returns {import('./layer.js').Content}
 */
export function bundleDialog({ app, close, signal }) {
  const review = app.store.get().review;
  const error = h('p.field-error.grow', { role: 'alert' });
  const go = h('button.btn.btn-primary', { type: 'submit' }, icon('bug'), 'Make the bundle');
  const note = h('textarea.textarea', {
    id: 'bundle-note',
    rows: 4,
    maxlength: 8000,
    placeholder: 'The stop sign behind the bus is lost for twelve frames.',
  });
  const range = createFrameRange(review, {
    id: 'bundle',
    begin: OFFERED,
    most: MOST,
    changed: (wrong) => {
      setText(error, wrong);
      go.disabled = wrong !== '';
      sayExpected();
    },
  });
  const only = review?.selected
    ? tick('checkbox', {}, `Only about track ${trackName(review.selected, review.docs[review.selected])}`)
    : null;

  const expected = h('p.field-hint');
  const goingOn = h('p.field-hint', { role: 'status' });
  /** Update the expectation after a change of frames or tracks. */
  function sayExpected() {
    if (review === null) return;
    const corrected = correctedKeys(review);
    const meant = only?.input.checked ? corrected.filter((key) => key === review.selected) : corrected;
    setText(expected, `${expectedWords(meant.length)} The file contains pictures of the drive; send it only to people who may see them.`);
    const found = range.value();
    const cut =
      'error' in found
        ? []
        : meant.filter((key) => {
            const span = shownSpan(review.docs[key], review.tracks);
            return span !== null && span.first < found.stop && span.last >= found.stop;
          });
    setText(
      goingOn,
      'error' in found
        ? ''
        : goingOnWords(
            cut.map((key) => trackName(key, review.docs[key])),
            found.stop - 1,
          ),
    );
    goingOn.hidden = goingOn.textContent === '';
  }
  only?.input.addEventListener('change', sayExpected, { signal });

  async function submit() {
    const found = range.value();
    if ('error' in found || !review?.run) return;
    go.disabled = true;
    try {
      const { id } = review.run;
      const output = await app.load(
        () =>
          app.api.makeBundle(
            id,
            { ...found, note: note.value.trim(), ...(only?.input.checked && review.selected ? { tracks: [review.selected] } : {}) },
            { signal },
          ),
        putOutput,
      );
      toast('The bundle is being made. It will appear under Files.', {
        topic: `made-${output.id}`,
        action: {
          label: 'Files',
          run: () => {
            location.hash = '#/files';
          },
        },
      });
      tellWhenMade(app, output.id);
      close();
    } catch (thrown) {
      if (signal.aborted) return;
      setText(error, sentence(thrown));
      go.disabled = false;
    }
  }

  range.tell();
  return {
    title: 'Report a bug',
    size: 'narrow',
    submit,
    focus: note,
    body: h(
      'div.stack',
      h(
        'p.muted',
        'One ZIP file with the clip of these frames, the parameters and models, the output of the engine and your corrections. The recipient runs ',
        h('code.mono', 'tsr replay FILE'),
        ' to see whether it is fixed.',
      ),
      field('What is wrong', note),
      range.element,
      goingOn,
      only?.element,
      expected,
    ),
    footer: [error, h('button.btn', { onclick: close }, 'Cancel'), go],
  };
}
