// @ts-check
/** Report a bug: pack everything that is needed to reproduce it into one file. */

import { errorMessage } from '../../api/errors.js';
import { shownSpan } from '../../model/effective.js';
import { listNames, trackName } from '../../model/track_name.js';
import { correctedKeys } from '../../review/shown_tracks.js';
import { putOutput } from '../../store/actions/page.js';
import { h, setText } from '../dom.js';
import { count, plural } from '../../model/format.js';
import { icon } from '../icons.js';
import { notifyWhenFinished } from '../output_notice.js';
import { toast } from '../../core/toast.js';
import { createFrameRange } from './frame_range.js';
import { choiceInput, field } from './fields.js';

const INITIAL_FRAMES = 150;
const MAX_FRAMES = 3000;

/**
 * The expectation that the replay is compared with.
 *
 * @param {number} corrected   tracks that people accepted, rejected or corrected
 */
export function describeExpectation(corrected) {
  if (!corrected) return 'No track is corrected yet. Correct what is wrong first: the replay is compared with your corrections.';
  return `The replay is compared with your corrections of ${plural(corrected, 'track')}, as far as these frames show ${corrected === 1 ? 'it' : 'them'}.`;
}

/** Maximum number of tracks that a sentence names. */
const MAX_NAMED_TRACKS = 4;

/**
 * A warning about tracks that end after the clip; empty: none.
 *
 * @param {readonly string[]} names
 * @param {number} last   last frame of the clip
 */
export function describeCutTracks(names, last) {
  if (names.length === 0) return '';
  const named = listNames(names, MAX_NAMED_TRACKS);
  return `${names.length === 1 ? `Track ${named} continues` : `Tracks ${named} continue`} after frame ${count(last)}. Without all votes, a class is expected only if you set it. A later last frame includes ${names.length === 1 ? 'it' : 'them'} completely.`;
}

/** @type {import('./index.js').CreateDialog<'bundle'>} */
export function bundleDialog({ app, close, signal }) {
  const review = app.store.get().review;
  const errorText = h('p.field-error.grow', { role: 'alert' });
  const submitButton = h('button.btn.btn-primary', { type: 'submit' }, icon('bug'), 'Make the bundle');
  const noteInput = h('textarea.textarea', {
    id: 'bundle-note',
    rows: 4,
    maxlength: 8000,
    placeholder: 'The stop sign behind the bus is lost for twelve frames.',
  });
  const frameRange = createFrameRange(review, {
    id: 'bundle',
    initialLength: INITIAL_FRAMES,
    maxLength: MAX_FRAMES,
    onChange: (message) => {
      setText(errorText, message);
      submitButton.disabled = message !== '';
      showExpectation();
    },
  });
  const onlySelected = review?.selected
    ? choiceInput('checkbox', {}, `Only about track ${trackName(review.selected, review.docs[review.selected])}`)
    : null;

  const expectationText = h('p.field-hint');
  const cutTracksText = h('p.field-hint', { role: 'status' });
  /** Update the expectation after a change of frames or tracks. */
  function showExpectation() {
    if (review === null) return;
    const corrected = correctedKeys(review);
    const keys = onlySelected?.input.checked ? corrected.filter((key) => key === review.selected) : corrected;
    setText(
      expectationText,
      `${describeExpectation(keys.length)} The file contains pictures of the drive; send it only to people who may see them.`,
    );
    const range = frameRange.value();
    const cutKeys =
      'error' in range
        ? []
        : keys.filter((key) => {
            const span = shownSpan(review.docs[key], review.tracks);
            return span !== null && span.first < range.stop && span.last >= range.stop;
          });
    setText(
      cutTracksText,
      'error' in range
        ? ''
        : describeCutTracks(
            cutKeys.map((key) => trackName(key, review.docs[key])),
            range.stop - 1,
          ),
    );
    cutTracksText.hidden = cutTracksText.textContent === '';
  }
  onlySelected?.input.addEventListener('change', showExpectation);

  async function submit() {
    const range = frameRange.value();
    if ('error' in range || !review?.run) return;
    submitButton.disabled = true;
    try {
      const { id } = review.run;
      const output = await app.load(
        () =>
          app.api.makeBundle(
            id,
            {
              ...range,
              note: noteInput.value.trim(),
              ...(onlySelected?.input.checked && review.selected ? { tracks: [review.selected] } : {}),
            },
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
      notifyWhenFinished(app, output.id);
      close();
    } catch (thrown) {
      if (signal.aborted) return;
      setText(errorText, errorMessage(thrown));
      submitButton.disabled = false;
    }
  }

  frameRange.validate();
  return {
    title: 'Report a bug',
    size: 'narrow',
    submit,
    focus: noteInput,
    body: h(
      'div.stack',
      h(
        'p.muted',
        'One ZIP file with the clip of these frames, the parameters and models, the output of the engine and your corrections. The recipient runs ',
        h('code.mono', 'tsr replay FILE'),
        ' to see whether it is fixed.',
      ),
      field('What is wrong', noteInput),
      frameRange.element,
      cutTracksText,
      onlySelected?.element,
      expectationText,
    ),
    footer: [errorText, h('button.btn', { onclick: close }, 'Cancel'), submitButton],
  };
}
