// Says that a browser is too old: the modules of the page would fail without a word. It is no module itself, and its
// syntax is older than what it checks.
(() => {
  const isRecent = 'any' in AbortSignal && 'showPopover' in HTMLElement.prototype && 'checkVisibility' in Element.prototype;
  if (isRecent) return;
  document.documentElement.dataset.tooOld = 'yes'; // `main.js` does not start then
  addEventListener('DOMContentLoaded', () => {
    const note = document.createElement('p');
    note.className = 'boot-note';
    note.setAttribute('role', 'alert');
    note.textContent = 'This browser is too old for the page. Use Chrome or Edge from version 116, Firefox from 125 or Safari from 17.4.';
    document.body.prepend(note);
  });
})();
