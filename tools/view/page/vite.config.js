import {defineConfig} from 'vite';

// Script and style within the HTML file, which then needs nothing else.
const inOneFile = {
  name: 'in-one-file',
  enforce: 'post',
  generateBundle(options, bundle) {
    const page = Object.values(bundle).find((file) => file.fileName.endsWith('.html'));
    let script = '', style = '';
    for (const [name, file] of Object.entries(bundle)) {
      if (file === page) continue;
      if (file.type === 'chunk') script += file.code;
      if (name.endsWith('.css')) style += file.source;
      delete bundle[name];
    }
    page.source = page.source.replace(/<(script|link)[^>]*(src|href)="[^"]*assets[^"]*"[^>]*>(<\/script>)?\s*/g, '')
        .replace('</head>', () => `<style>${style}</style></head>`)
        .replace('</body>', () => `<script type="module">${script.replaceAll('</script', '<\\/script')}</script></body>`);
  },
};

// The page of gw-view; in mode "report" the page of a report.
export default defineConfig(({mode}) => ({
  base: './',
  plugins: mode === 'report' ? [inOneFile] : [],
  build: {
    target: 'es2022',
    chunkSizeWarningLimit: 1000,
    assetsInlineLimit: 0,
    rollupOptions: {input: mode === 'report' ? 'report.html' : 'index.html'},
  },
}));
