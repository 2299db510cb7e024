// @ts-check
/**
 * The verdicts in the whole drive that flip at the dragged tau: their number, and a button that goes from track to
 * track.
 */

import { flippedTracks, nextFlippedTrack } from '../../model/drive_flips.js';
import { seek, select } from '../../store/actions/review.js';
import { h, setText } from '../dom.js';
import { createLatestSender } from '../latest_sender.js';
import { plural } from '../../model/format.js';

/** @typedef {import('../../types.js').Flips} Flips */
/** @typedef {{run: string, tau: number}} Question */

/** @param {import('../../page-types.js').ViewApp} app @param {AbortSignal} signal */
export function createDriveFlips(app, signal) {
  const element = h('button.btn.btn-small.btn-quiet.lanes-drive-flips', { hidden: true });
  /** @type {Question|null} */ let currentQuestion = null;
  /** @type {Flips|null} */ let currentFlips = null;
  /** @type {readonly import('../../model/drive_flips.js').FlippedTrack[]} */ let places = [];
  /** @type {Record<string, unknown>|null} */ let docs = null;

  /** @param {Question} question */
  const countFlips = async (question) => {
    const flips = await app.api.flips(question.run, question.tau, { signal });
    if (currentQuestion !== question) return;
    currentFlips = flips;
    showFlips();
  };
  const sender = createLatestSender(countFlips, {
    pauseMs: 120,
    onError: (thrown) => {
      if (signal.aborted || currentQuestion === null) return;
      currentFlips = null;
      showText('Drive: not counted', thrown instanceof Error ? thrown.message : 'The server did not answer. Drag tau again.', false);
    },
  });
  signal.addEventListener('abort', () => sender.stop(), { once: true });

  /** @param {string} text @param {string} title @param {boolean} isClickable */
  function showText(text, title, isClickable) {
    setText(element, text);
    element.title = title;
    element.disabled = !isClickable;
  }

  function showFlips() {
    const { review } = app.store.get();
    if (currentFlips === null || review === null) return;
    places = flippedTracks(currentFlips, review.docs);
    const flipCount = places.reduce((sum, { flips }) => sum + flips, 0);
    const allVerdicts = plural(currentFlips.verdicts, 'verdict');
    if (flipCount === 0) {
      showText('Drive: no verdict flips', `None of the run’s ${allVerdicts} would flip`, false);
      return;
    }
    const tracks = new Set(places.map(({ key }) => key)).size;
    const newVerdict = currentFlips.tau < currentFlips.run_tau ? 'be rejected' : 'be confident';
    showText(
      `Drive: ${plural(flipCount, 'verdict flips', 'verdicts flip')} in ${plural(tracks, 'track')}`,
      `They would ${newVerdict}, of the run’s ${allVerdicts}. Click: next track with a flip`,
      true,
    );
  }

  element.addEventListener('click', () => {
    const { review } = app.store.get();
    const place = review && nextFlippedTrack(places, review.selected, review.frame);
    if (!place) return;
    app.store.dispatch(select, place.key);
    app.store.dispatch(seek, place.frame);
  });

  return {
    element,
    /** @param {import('../../state-types.js').ReviewState} review   its `tau` is null while it is the run's own, at which nothing flips */
    update({ run, tau, docs: newDocs }) {
      if (run === null || tau === null) {
        currentQuestion = currentFlips = null;
        element.hidden = true;
        return;
      }
      if (docs !== newDocs) {
        docs = newDocs;
        showFlips();
      }
      if (currentQuestion !== null && currentQuestion.run === run.id && currentQuestion.tau === tau) return;
      if (currentQuestion === null) showText('Drive: counting…', '', false);
      currentQuestion = { run: run.id, tau };
      element.hidden = false;
      sender.push(currentQuestion);
    },
  };
}
