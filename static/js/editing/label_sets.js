// @ts-check
/**
 * Keeps the labels in the store equal to those of the video on the screen, and current when others change the set.
 *
 * @typedef {import('../state-types.js').State} State
 * @typedef {import('../types.js').LabelChange} LabelChange
 *
 * @typedef {object} LabelSets
 * @property {() => Promise<void>} reload   load the sets and the labels
 * @property {() => void} sync              load the labels of the video on the screen if they are not in the store
 * @property {(event: import('../types.js').ServerEvent) => Promise<void>} receive   handles an event about a changed set
 * @property {(change: LabelChange, set?: string|null) => Promise<import('../api/labels.js').LabelAnswer>} change   make
 *   a change, by default in the set on the screen; the store has it when the promise resolves
 * @property {(set: string, file: File, create: boolean) => Promise<import('../api/labels.js').ImportedLabels>} importFile   add the labels of a file that the set lacks;
 *   create: make the set if it does not exist
 */
import { ApiError } from '../api/errors.js';
import { setLabelSets, setLabels } from '../store/actions/page.js';

/** The video on the screen if it has its own label set; null: the library's default applies. @param {State} state */
const labelVideo = ({ review }) => (review?.video.label_set ? review.video.id : null);

/** Key of the set of the labels in the store; null: not known yet. @param {State} state @returns {string|null} */
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
 * @param {Pick<import('../api/labels.js').LabelRoutes, 'labels'|'labelSets'|'labelHistory'|'changeLabels'|'importLabels'>} setup.api
 * @param {() => string} setup.author
 * @param {(text: string) => void} setup.notify   shows a sentence about somebody else's change
 * @param {() => void} [setup.onChanged]   called when another set or version is on the screen, so that the engine's results get other labels
 * @returns {LabelSets}
 */
export function createLabelSets({ store, api, author, notify, onChanged = () => {} }) {
  /** @type {string|null} */
  let loadedVideo = null;
  let requestCount = 0;
  /** Video and version of the labels in the store when they arrived. @type {{video: string|null, version: string|null}|null} */
  let shown = null;
  /** Versions that this page made; events about them need no notice. @type {Set<string>} */
  const ownVersions = new Set();
  /** By set: the newest version that is no news. Events also say that a set is used by a video or by the library. @type {Map<string, number>} */
  const knownVersions = new Map();
  /** Resolves after this page's current changes: an event can arrive before their answers. */
  let changing = Promise.resolve();

  async function reload() {
    const number = ++requestCount;
    loadedVideo = labelVideo(store.get());
    const [sets, labels] = await Promise.all([api.labelSets(), api.labels(loadedVideo)]);
    // a later request has overtaken this answer
    if (number !== requestCount) return;
    for (const { key, version } of sets) if (!knownVersions.has(key)) knownVersions.set(key, version);
    store.dispatch((state) => setLabels(setLabelSets(state, sets), labels));
    const current = { video: videoOf(store.get()), version: versionOf(store.get()) };
    const hasChanged = shown !== null && shown.video === current.video && shown.version !== current.version;
    shown = current;
    if (hasChanged) onChanged();
  }

  /**
   * Note the version that a change of this page makes. Its event can arrive before the answer.
   * @template {{version: number}} T
   * @param {string} set
   * @param {Promise<T>} request
   * @returns {Promise<T>}
   */
  function ownChange(set, request) {
    const done = request
      .then((answer) => {
        ownVersions.add(`${set} ${answer.version}`);
        return answer;
      })
      // also after a refusal: its cause may be a change by somebody else that has not arrived yet
      .finally(() => reload().catch(() => {}));
    changing = Promise.allSettled([changing, done]).then(() => {});
    return done;
  }

  return {
    reload,
    sync() {
      const state = store.get();
      if (state.labelSets !== null && labelVideo(state) !== loadedVideo) void reload().catch(() => {});
      else if (shown !== null && shown.video !== videoOf(state)) shown = { ...shown, video: videoOf(state) };
    },
    async receive({ subject, data }) {
      await changing;
      const isOwn = ownVersions.has(`${subject} ${data.version}`);
      const isNews = !isOwn && data.version > (knownVersions.get(subject) ?? 0);
      if (isOwn || isNews) knownVersions.set(subject, data.version);
      // the labels after the user's own change may not have arrived yet
      if (isOwn && (store.get().labelSets?.find(({ key }) => key === subject)?.version ?? 0) >= data.version) return;
      await reload();
      if (!isNews || subject !== labelSetKey(store.get())) return;
      const entry = (await api.labelHistory(subject)).find(({ version }) => version === data.version);
      if (entry) notify(`${entry.author}: ${entry.sentence}`);
    },
    async change(change, set = labelSetKey(store.get())) {
      if (set === null) throw new ApiError(0, 'offline', 'The label sets are not loaded yet. Try again in a moment.');
      return ownChange(set, api.changeLabels(set, author(), change));
    },
    importFile: (set, file, create) => ownChange(set, api.importLabels(set, file, author(), create)),
  };
}
