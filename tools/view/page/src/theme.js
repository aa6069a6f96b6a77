// Dark or light: as the system is set, until somebody presses the button.
export function startTheme(button, apply) {
  const set = (name) => {
    document.documentElement.dataset.theme = name;
    apply();
  };
  button.addEventListener('click', () => set(document.documentElement.dataset.theme === 'dark' ? 'light' : 'dark'));
  set(matchMedia('(prefers-color-scheme: light)').matches ? 'light' : 'dark');
}
