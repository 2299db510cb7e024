// @ts-check
/**
 * Offers the corrections of an earlier run of the video when a later run is opened. An offer that was dismissed or
 * accepted is not repeated in this browser for the same state of the earlier run.
 *
 * @typedef {import('../page-types.js').App} App
 * @typedef {import('../state-types.js').Banner} Banner
 * @typedef {import('../types.js').Run} Run
 * @typedef {import('../types.js').Earlier} Earlier
 */
import { hideBanner, showBanner } from '../store/actions/page.js';
import { changeReview } from '../store/actions/review.js';
import { plural } from '../model/format.js';
import { isDismissed, dismiss } from '../core/preferences.js';
import { runName } from '../model/describe_run.js';

/** The name under which a dismissed offer is remembered. @param {string} run @param {Earlier} found */
const offerName = (run, { run_id, seq }) => `earlier/${run}/${run_id}/${seq}`;

/**
 * @param {Run} run       the open run
 * @param {Run} source    the earlier one
 * @param {Earlier} found
 * @returns {Banner}
 */
function offerBanner(run, source, found) {
  return {
    id: 'earlier',
    tone: 'info',
    once: offerName(run.id, found),
    action: { label: 'Carry them over', operation: 'carry-over' },
    text: `People have corrected ${plural(found.tracks, 'track')} in an earlier run, “${runName(source)}”. This run does not have these corrections yet.`,
  };
}

/**
 * Find corrections that the run lacks, and offer them.
 *
 * @param {Pick<App, 'store'|'api'>} app
 * @param {Run} run   the open run
 * @param {AbortSignal} signal
 */
export async function offerEarlierCorrections({ store, api }, run, signal) {
  if (run.kind === 'whatif' || run.state !== 'complete') return;
  const found = await api.earlier(run.id, { signal });
  const source = store.get().runs[run.video_id]?.find(({ id }) => id === found?.run_id);
  if (!found || !source || isDismissed(offerName(run.id, found))) return;
  store.dispatch((state) =>
    state.review?.run?.id === run.id ? showBanner(changeReview(state, { earlier: found }), offerBanner(run, source, found)) : state,
  );
}

/** End the offer, because the corrections have been adopted. @param {Pick<App, 'store'>} app @param {string} run @param {string} from */
export function endOffer({ store }, run, from) {
  const earlier = store.get().review?.earlier;
  if (!earlier || earlier.run_id !== from || store.get().review?.run?.id !== run) return;
  dismiss(offerName(run, earlier));
  store.dispatch((state) => hideBanner(changeReview(state, { earlier: null }), 'earlier'));
}
