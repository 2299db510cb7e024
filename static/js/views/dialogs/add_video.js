// @ts-check
/** Add videos from the server's machine: browse folders, or type a path. */

import { errorMessage } from '../../api/errors.js';
import { addedMessage, processAll, togglePath } from '../../model/several_videos.js';
import { putVideo } from '../../store/actions/page.js';
import { fill, h, setText } from '../dom.js';
import { loadingState } from '../placeholders.js';
import { bytes, count, plural } from '../../model/format.js';
import { icon } from '../icons.js';
import { toast } from '../../core/toast.js';
import { textInput } from './fields.js';

/** @type {import('./index.js').CreateDialog<'add-video'>} */
export function addVideoDialog({ app, close, signal }) {
  /** Paths of the chosen videos in this folder. @type {readonly string[]} */
  let chosenPaths = [];
  /** Paths of all videos in this folder. @type {readonly string[]} */
  let folderPaths = [];
  let folderPath = '';
  let latestRequest = 0;
  const pathInput = textInput('add-path', {
    class: 'input grow',
    spellcheck: 'false',
    'aria-describedby': 'add-error add-hint',
    oninput: () => choose([], pathInput.value),
  });
  const errorText = h('p.field-error', { id: 'add-error', role: 'alert', hidden: true });
  const list = h('div.browser', { 'aria-label': 'Folders and videos', role: 'group' });
  const addButton = h('button.btn.btn-primary', { type: 'submit' }, 'Add');
  const roots = app.store.get().session?.roots ?? [];
  const chooseAllButton = h('button.btn.btn-small', {
    hidden: true,
    onclick: () => choose(chosenPaths.length === folderPaths.length ? [] : folderPaths),
  });
  const rootButtons = h(
    'div.row.browser-roots',
    ...roots.map((root) => h('button.btn.btn-small', { title: root, onclick: () => open(root) }, icon('folder'), lastName(root))),
    h('span.grow'),
    chooseAllButton,
  );

  /** @param {unknown} thrown */
  function showError(thrown) {
    errorText.hidden = false;
    setText(errorText, errorMessage(thrown));
  }

  /** @param {readonly string[]} paths @param {string} [typed]   text of the field instead of the paths */
  function choose(paths, typed) {
    chosenPaths = paths;
    errorText.hidden = true;
    const pathText = typed ?? (chosenPaths.length === 1 ? chosenPaths[0] : folderPath);
    if (pathInput.value !== pathText) pathInput.value = pathText;
    setText(addButton, chosenPaths.length > 1 ? `Add ${plural(chosenPaths.length, 'video')}` : 'Add');
    chooseAllButton.hidden = folderPaths.length < 2;
    setText(chooseAllButton, chosenPaths.length === folderPaths.length ? 'Choose none' : `Choose all ${count(folderPaths.length)}`);
    for (const other of list.querySelectorAll('[data-path]')) {
      other.setAttribute('aria-pressed', String(chosenPaths.includes(other instanceof HTMLElement ? (other.dataset.path ?? '') : '')));
    }
  }

  /** @param {string|null} path */
  async function open(path) {
    const request = ++latestRequest;
    folderPaths = [];
    choose([]);
    list.replaceChildren(loadingState('Reading the folder', { signal, retry: () => open(path) }));
    try {
      const folder = await app.api.browse(path, { signal });
      if (request !== latestRequest) return; // another folder has been opened meanwhile
      folderPath = folder.path;
      folderPaths = folder.videos.map((video) => video.path);
      const { parent } = folder;
      fill(
        list,
        parent !== null && createRow('up', '..', 'One folder up', () => open(parent)),
        folder.truncated && h('p.muted.browser-none', truncatedMessage(folder)),
        folder.folders.map((name) =>
          createRow('folder', lastName(name), name, () => open(name.startsWith('/') ? name : join(folder.path, name))),
        ),
        folder.videos.map((video) =>
          createRow('film', video.name, bytes(video.size), () => choose(togglePath(chosenPaths, video.path)), video.path),
        ),
        folder.videos.length === 0 &&
          !folder.truncated &&
          h('p.muted.browser-none', folder.folders.length ? 'No video in this folder.' : 'This folder is empty: no video, no folder.'),
      );
      choose([]);
    } catch (thrown) {
      if (signal.aborted || request !== latestRequest) return;
      fill(list);
      showError(thrown);
    }
  }

  async function submit() {
    const paths = chosenPaths.length ? chosenPaths : [pathInput.value.trim()];
    if (!paths[0]) {
      errorText.hidden = false;
      setText(errorText, 'Choose a video, or type its path.');
      return;
    }
    addButton.disabled = true;
    errorText.hidden = true;
    const { done, left, errors } = await processAll(
      paths,
      (path) => {
        if (paths.length > 1) setText(addButton, `Adding ${count(paths.indexOf(path) + 1)} of ${count(paths.length)} …`);
        return app.load(() => app.api.addVideo(path, { signal }), putVideo);
      },
      errorMessage,
    );
    addButton.disabled = false;
    if (done.length) toast(addedMessage(done));
    if (signal.aborted) return;
    if (left.length === 0) {
      close();
      return;
    }
    choose(chosenPaths.length ? left : [], chosenPaths.length ? undefined : pathInput.value);
    errorText.hidden = false;
    setText(errorText, errors.join(' '));
  }

  // Enter chooses a video; pressed again, it adds the chosen ones
  list.addEventListener('keydown', (event) => {
    if (event.key !== 'Enter' || !(event.target instanceof HTMLElement) || event.target.ariaPressed !== 'true') return;
    event.preventDefault();
    void submit();
  });
  void open(null);
  return {
    title: 'Add videos from a folder',
    size: 'middle',
    submit,
    focus: pathInput,
    body: h(
      'div.stack',
      h(
        'div.field',
        h('label.field-label', { for: 'add-path' }, 'Path'),
        pathInput,
        h(
          'span.field-hint',
          { id: 'add-hint' },
          'Choose one or several below, or type a path. Files are not moved. Videos can be added from these folders:',
        ),
      ),
      rootButtons,
      list,
      errorText,
    ),
    footer: [h('span.grow'), h('button.btn', { onclick: close }, 'Cancel'), addButton],
  };
}

/**
 * @param {import('../icons.js').IconName} name
 * @param {string} text
 * @param {string} detail
 * @param {() => void} onClick
 * @param {string} [video]   its path
 */
function createRow(name, text, detail, onClick, video) {
  return h(
    'button.browser-row',
    { title: detail, onclick: onClick, 'aria-pressed': video ? 'false' : null, dataset: video ? { path: video } : {} },
    icon(name),
    h('span.truncate.grow', text),
    video && h('span.muted.small', detail),
  );
}

/**
 * The message for a folder with more entries than are listed.
 * @param {Pick<import('../../api/videos.js').Folder, 'folders'|'videos'>} folder
 */
export function truncatedMessage({ folders, videos }) {
  return `Only the first ${plural(folders.length + videos.length, 'folder or video', 'folders and videos')} by name are listed. Type the path of another one above.`;
}

/** @param {string} path */
function lastName(path) {
  return path.split('/').filter(Boolean).pop() ?? path;
}

/** @param {string} folder @param {string} name */
function join(folder, name) {
  return `${folder.replace(/\/$/, '')}/${name}`;
}
