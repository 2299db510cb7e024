// @ts-check
/**
 * Keeps the labels in the store those of the video on the screen, and up to date with what others make of the set.
 *
 * @typedef {import('../state-types.js').State} State
 * @typedef {import('../types.js').LabelChange} LabelChange
 *
 * @typedef {object} LabelSets
 * @property {() => Promise<void>} reload   ask for the sets and the labels
 * @property {() => void} sync              another video may be on the screen, with another set
 * @property {(event: import('../types.js').ServerEvent) => Promise<void>} receive   a set has changed
 * @property {(change: LabelChange, set?: string|null) => Promise<import('../api/labels.js').LabelAnswer>} change   make a change, in the set that is on the screen
 *   unless another is named; the store has it once this is done
 * @property {(set: string, file: File, create: boolean) => Promise<import('../api/labels.js').LabelsBrought>} bring   add what a file has and the set lacks;
 *   create: make the set where there is none
 */
import { ApiError } from '../api/errors.js';
import { setLabelSets, setLabels } from '../store/actions/page.js';

/** The video whose own set is on the screen; null: the library's is. @param {State} state */
const labelVideo = ({ review }) => (review?.video.label_set ? review.video.id : null);

/** Key of the set that the labels in the store are of; null: not known yet. @param {State} state @returns {string|null} */
export const labelSetKey = ({ review, labelSets }) => review?.video.label_set ?? labelSets?.find((set) => set.default)?.key ?? null;

/** @param {State} state */
const videoOf = ({ review }) => review?.video.id ?? null;

/** The set on the screen and its version; null: not known yet. @param {State} state */
function versionOf(state) {
  const key = labelSetKey(state);
  const set = state.labelSets?.find((one) => one.key === key);
  return set ? `${set.key} ${set.version}` : null;
}

/**
 * @param {object} setup
 * @param {import('../state-types.js').Store} setup.store
 * @param {Pick<import('../api/labels.js').LabelRoutes, 'labels'|'labelSets'|'labelHistory'|'changeLabels'|'bringLabels'>} setup.api
 * @param {() => string} setup.author
 * @param {(text: string) => void} setup.say   what somebody else has changed, in a sentence
 * @param {() => void} [setup.turned]   another set is on the screen, or another version of it: what the engine read has other labels
 * @returns {LabelSets}
 */
export function createLabelSets({ store, api, author, say, turned = () => {} }) {
  /** @type {string|null} */
  let loaded = null;
  let asked = 0;
  /** What the labels in the store were when they came. @type {{video: string|null, version: string|null}|null} */
  let shown = null;
  /** Versions that this page has made: they are no news. @type {Set<string>} */
  const own = new Set();
  /** Changes of this page that are under way: an event can come before their answer. */
  let changing = Promise.resolve();

  async function reload() {
    const mine = ++asked;
    loaded = labelVideo(store.get());
    const [sets, labels] = await Promise.all([api.labelSets(), api.labels(loaded)]);
    // an answer that was overtaken by a later question is older than that one's
    if (mine !== asked) return;
    store.dispatch((state) => setLabels(setLabelSets(state, sets), labels));
    const now = { video: videoOf(store.get()), version: versionOf(store.get()) };
    const other = shown !== null && shown.video === now.video && shown.version !== now.version;
    shown = now;
    if (other) turned();
  }

  /** @param {string} set @param {LabelChange} change */
  async function make(set, change) {
    try {
      const answer = await api.changeLabels(set, author(), change);
      own.add(`${set} ${answer.version}`);
      return answer;
    } finally {
      // also after a refusal: what stands in the way may be somebody else's change that is not here yet
      await reload().catch(() => {});
    }
  }

  return {
    reload,
    sync() {
      const state = store.get();
      if (state.labelSets !== null && labelVideo(state) !== loaded) void reload().catch(() => {});
      else if (shown !== null && shown.video !== videoOf(state)) shown = { ...shown, video: videoOf(state) };
    },
    async receive({ subject, data }) {
      await changing;
      const mine = own.has(`${subject} ${data.version}`);
      // the labels that one's own change has left may not have come
      if (mine && (store.get().labelSets?.find(({ key }) => key === subject)?.version ?? 0) >= data.version) return;
      await reload();
      if (mine || subject !== labelSetKey(store.get())) return;
      const made = (await api.labelHistory(subject)).find(({ version }) => version === data.version);
      if (made) say(`${made.author}: ${made.sentence}`);
    },
    async change(change, set = labelSetKey(store.get())) {
      if (set === null) throw new ApiError(0, 'offline', 'The label sets are not loaded yet. Try again in a moment.');
      const made = make(set, change);
      changing = Promise.allSettled([changing, made]).then(() => {});
      return made;
    },
    async bring(set, file, create) {
      const answer = await api.bringLabels(set, file, author(), create);
      own.add(`${set} ${answer.version}`);
      await reload().catch(() => {});
      return answer;
    },
  };
}
