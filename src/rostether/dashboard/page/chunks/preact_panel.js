import{d as e,p as t}from"./preact.js";function r(o){return{mount(n,l){return e(t(o,{context:l}),n),()=>e(null,n)}}}export{r as a};
