// @ts-check
/** Going from the end of one queue to the next video. */

import { openVideos } from '../model/open_videos.js';
import { reviewAddress } from '../model/route.js';
import { setVideos } from '../store/actions/page.js';
import { toast } from '../core/toast.js';
import { operation } from './helpers.js';

/** Key of the operation, for notices that mention it. */
export const NEXT_VIDEO_KEY = 'Alt+J';

/** @param {import('../state-types.js').State} state */
const otherVideos = ({ videos, route }) => openVideos(videos, route.screen === 'review' ? route.video : undefined);

/**
 * Open the next video that has open tracks. The list is loaded again, because others review too.
 *
 * @param {Pick<import('../page-types.js').ViewApp, 'store'|'api'|'load'>} app
 * @param {import('../core/toast.js').Notify} [notify]
 */
export async function openNextVideo({ store, api, load }, notify = toast) {
  try {
    await load(() => api.videos(), setVideos);
  } catch {
    // offline: use the list that is known
  }
  const { next } = otherVideos(store.get());
  if (next === null) notify('No other video has open tracks.', { topic: 'queue' });
  else location.hash = reviewAddress(next.id);
}

/** @type {import('../page-types.js').Operation[]} */
export const nextVideo = [
  operation({
    id: 'next-video',
    label: 'Next video with open tracks',
    keys: [NEXT_VIDEO_KEY],
    icon: 'film',
    group: 'Queue',
    disabled: (state) => (otherVideos(state).next === null ? 'No other video has open tracks.' : null),
    run: (app) => void openNextVideo(app),
  }),
];
