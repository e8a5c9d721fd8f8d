import { defineConfig } from 'vite';
import { viteSingleFile } from 'vite-plugin-singlefile';

// One page a build, for each becomes one file: PAGE is page (runs), study or map, OUT the folder.
export default defineConfig({
  root: __dirname,
  plugins: [viteSingleFile({ removeViteModuleLoader: true })],
  build: {
    target: 'es2022',
    outDir: process.env.OUT ?? 'dist',
    emptyOutDir: false,
    reportCompressedSize: false,
    chunkSizeWarningLimit: 2000,
    rollupOptions: { input: `${__dirname}/${process.env.PAGE ?? 'page'}.html` },
  },
  logLevel: 'warn',
});
