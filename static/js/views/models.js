// @ts-check
/** The screen of model versions: origin, figures, and the version in use. */

import { dropOutputOrModel, openDialog, putModel, setModels } from '../store/actions/page.js';
import { h, reconcile, setText } from './dom.js';
import { errorState, loadingState } from './placeholders.js';
import { plural } from '../model/format.js';
import { hasRole } from '../model/team.js';
import { icon } from './icons.js';
import { createModelCard } from './model_card.js';
import { toast } from '../core/toast.js';
import { pageHeading } from './headings.js';
import { toastErrors } from './toast_errors.js';

/** @typedef {import('../types.js').ModelVersion} ModelVersion */

/** @type {import('../page-types.js').CreateView} */
export function createModels(app) {
  const { store, api } = app;
  const lifetime = new AbortController();
  const signal = AbortSignal.any([lifetime.signal, app.signal]);
  const totalText = h('span.muted');
  const rollBackButton = h(
    'button.btn',
    { hidden: true, title: 'Undo the last promotion', onclick: () => void rollBack() },
    icon('undo'),
    'Roll back',
  );
  const list = h('ul.model-list', { 'aria-label': 'Model versions' });
  const notice = h('div.library-notice', loadingState('Loading the model versions', { retry: load, signal }));
  const element = h(
    'div.library',
    h(
      'div.library-inner.page-inner',
      pageHeading(
        'Models',
        totalText,
        rollBackButton,
        h('button.btn.btn-primary', { onclick: () => store.dispatch(openDialog, { kind: 'retrain' }) }, icon('run'), 'Retrain'),
      ),
      h('p.muted', 'New runs use the version in use; existing runs keep theirs. A version never changes.'),
      notice,
      list,
    ),
  );
  /** @type {WeakMap<HTMLElement, ReturnType<typeof createModelCard>>} */ const cards = new WeakMap();
  /** @type {readonly ModelVersion[]|null} */ let shownModels = null;

  const onAction = {
    promote: (/** @type {ModelVersion} */ version) =>
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
      }),
    cancel: (/** @type {ModelVersion} */ version) => void storeModel(() => api.changeModel(version.id, 'cancel', { signal })),
    resume: (/** @type {ModelVersion} */ version) => void storeModel(() => api.changeModel(version.id, 'resume', { signal })),
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

  /** @param {() => Promise<ModelVersion>} request */
  const storeModel = (request) => toastErrors(() => app.load(request, putModel), signal);

  const rollBack = () =>
    toastErrors(async () => {
      const version = await api.rollBackModels({ signal });
      await load();
      toast(`${version.name} is in use again.`, { tone: 'good' });
    }, signal);

  async function load() {
    try {
      await app.load(() => api.models({ signal: app.signal }), setModels);
    } catch (thrown) {
      if (signal.aborted) return;
      notice.hidden = false;
      notice.replaceChildren(errorState('The model versions could not be listed', thrown, () => load()));
    }
  }

  void load();
  return {
    element,
    update(state) {
      element.classList.toggle('models-closed', !hasRole(state.session, 'admin'));
      const models = state.models;
      if (models === null || models === shownModels) return;
      shownModels = models;
      notice.hidden = true;
      setText(totalText, plural(models.length, 'version'));
      rollBackButton.hidden = models.find(({ active }) => active)?.id === 'shipped';
      reconcile(
        list,
        models,
        ({ id }) => id,
        (version) => {
          const card = createModelCard(version, onAction);
          cards.set(card.element, card);
          return card.element;
        },
        (item, version) => cards.get(item)?.show(version, models),
      );
    },
    destroy: () => lifetime.abort(),
  };
}
