// @ts-check
/** The screen of model versions: origin, figures, and the version in use. */

import { sentence } from '../api/errors.js';
import { dropOutputOrModel, openDialog, putModel, setModels } from '../store/actions/page.js';
import { h, reconcile, setText } from './dom.js';
import { failure, waiting } from './empty.js';
import { plural } from '../model/format.js';
import { may } from '../model/team.js';
import { icon } from './icons.js';
import { createModelCard } from './model-card.js';
import { toast } from '../core/toast.js';
import { pageHead } from './heads.js';

/** @typedef {import('../types.js').ModelVersion} ModelVersion */

/**
 * @param {import('../page-types.js').App} app
 * @returns {import('../page-types.js').View}
 */
export function createModels(app) {
  const { store, api } = app;
  const ended = new AbortController();
  const signal = AbortSignal.any([ended.signal, app.signal]);
  const total = h('span.muted');
  const back = h(
    'button.btn',
    { hidden: true, title: 'Undo the last promotion', onclick: () => void rollBack() },
    icon('undo'),
    'Roll back',
  );
  const list = h('ul.model-list', { 'aria-label': 'Model versions' });
  const notice = h('div.library-notice', waiting('Loading the model versions', { retry: load, signal }));
  const element = h(
    'div.library',
    h(
      'div.library-inner.page-inner',
      pageHead(
        'Models',
        total,
        back,
        h('button.btn.btn-primary', { onclick: () => store.dispatch(openDialog, { kind: 'retrain' }) }, icon('run'), 'Retrain'),
      ),
      h('p.muted', 'New runs use the version in use; existing runs keep theirs. A version never changes.'),
      notice,
      list,
    ),
  );
  /** @type {WeakMap<HTMLElement, ReturnType<typeof createModelCard>>} */
  const cards = new WeakMap();
  /** @type {readonly ModelVersion[]|null} */
  let shown = null;

  const acts = {
    promote: (/** @type {ModelVersion} */ version) =>
      void act(async () => {
        store.dispatch(openDialog, {
          kind: 'confirm',
          data: {
            title: `Promote ${version.name}?`,
            confirm: 'Promote',
            text: 'New runs will use it. Roll back undoes this.',
            run: async () => {
              await api.changeModel(version.id, 'promote');
              await load();
              toast(`${version.name} is in use.`, { tone: 'good' });
            },
          },
        });
      }),
    cancel: (/** @type {ModelVersion} */ version) => void act(async () => put(() => api.changeModel(version.id, 'cancel', { signal }))),
    resume: (/** @type {ModelVersion} */ version) => void act(async () => put(() => api.changeModel(version.id, 'resume', { signal }))),
    remove: (/** @type {ModelVersion} */ version) =>
      store.dispatch(openDialog, {
        kind: 'confirm',
        data: {
          title: 'Delete this version?',
          confirm: 'Delete',
          danger: true,
          text: `${version.name} and its files will be deleted. This cannot be undone.`,
          note: 'A version that runs or other versions depend on cannot be deleted.',
          run: async () => {
            await api.removeModel(version.id);
            store.dispatch(dropOutputOrModel, version.id);
            toast(`${version.name} was deleted.`);
          },
        },
      }),
  };

  /** @param {() => Promise<ModelVersion>} ask */
  const put = async (ask) => void (await app.load(ask, putModel));

  /** @param {() => Promise<void>} what */
  async function act(what) {
    try {
      await what();
    } catch (thrown) {
      if (!signal.aborted) toast(sentence(thrown), { tone: 'bad' });
    }
  }

  const rollBack = () =>
    act(async () => {
      const now = await api.rollBackModels({ signal });
      await load();
      toast(`${now.name} is in use again.`, { tone: 'good' });
    });

  async function load() {
    try {
      await app.load(() => api.models({ signal: app.signal }), setModels);
    } catch (thrown) {
      if (signal.aborted) return;
      notice.hidden = false;
      notice.replaceChildren(failure('The model versions could not be listed', thrown, () => load()));
    }
  }

  void load();
  return {
    element,
    update(state) {
      element.classList.toggle('models-closed', !may(state.session, 'admin'));
      const models = state.models;
      if (models === null || models === shown) return;
      shown = models;
      notice.hidden = true;
      setText(total, plural(models.length, 'version'));
      back.hidden = models.find(({ active }) => active)?.id === 'shipped';
      reconcile(
        list,
        models,
        ({ id }) => id,
        (version) => {
          const card = createModelCard(version, acts);
          cards.set(card.element, card);
          return card.element;
        },
        (item, version) => cards.get(item)?.show(version, models),
      );
    },
    destroy() {
      ended.abort();
      element.remove();
    },
  };
}
