// Runs before the first paint, so that the page does not flash in the other theme. `theme.js` does the rest.
(() => {
  let chosen = null;
  try {
    chosen = localStorage.getItem('tsr.theme');
  } catch {
    // Storage can be disabled; then the system's theme applies.
  }
  const dark = chosen === 'dark' || (chosen !== 'light' && matchMedia('(prefers-color-scheme: dark)').matches);
  document.documentElement.dataset.theme = dark ? 'dark' : 'light';
})();
