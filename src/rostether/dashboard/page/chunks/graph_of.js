function s(e){return{topics:e.topics.value,publishers:e.publishers.value,subscribers:e.subscribers.value,services:e.services.value,ownNode:e.info.value?.metadata?.node}}export{s as a};
